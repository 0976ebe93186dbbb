//! Units and placement (U1–U3).

use glamx::DVec3;

use super::finding::{Finding, judged, mm};
use super::part::Parts;
use crate::profile::bounds::{PLACED, SCALE, SIZES};
use crate::robot::Shape;
use crate::verdict::{Check, figure};

/// U1, U2, U3.
pub(super) fn checks(parts: &Parts) -> Vec<Check> {
    vec![scales(parts), size(parts), placement(parts)]
}

fn scales(parts: &Parts) -> Check {
    let links = parts.robot.links.iter();
    let shapes = links.flat_map(|l| l.visuals.iter().chain(&l.collisions).map(|s| (&l.name, s)));
    let finding = |(link, shape): (&String, &Shape)| {
        let off = (shape.scale - DVec3::ONE).abs().max_element();
        let Shape { line, source, scale, .. } = shape;
        Finding {
            severity: off / SCALE,
            value: off,
            unit: "off 1",
            words: format!("line {line}: link `{link}` scales `{source}` by {scale}"),
        }
    };
    judged("U1", shapes.map(finding).collect(), vec![])
}

fn size(parts: &Parts) -> Check {
    let diagonal = parts.diagonal;
    let told = format!("diagonal {} m at rest", figure(diagonal));
    let check = if SIZES.contains(&diagonal) { Check::pass("U2") } else { Check::fail("U2") };
    check.value(diagonal).evidence(told)
}

fn placement(parts: &Parts) -> Check {
    let lowest = parts.bounds.min.z;
    let root = parts.robot.root();
    let base = object::mesh::Bounds::of(parts.parts[root].points());
    let mut findings = vec![Finding {
        severity: lowest.abs() / PLACED.least,
        value: lowest,
        unit: "m",
        words: format!("the lowest point lies at z = {}", mm(lowest)),
    }];
    if base.min.x <= base.max.x {
        let off = base.centre().truncate().length();
        let allowed = PLACED.of(base.size().truncate().max_element());
        let name = &parts.robot.links[root].name;
        findings.push(Finding {
            severity: off / allowed,
            value: off,
            unit: "m",
            words: format!("the centre of `{name}` lies {} off the z axis", mm(off)),
        });
    }
    judged("U3", findings, vec![])
}
