//! Pictures of numbers, as SVG: bars of yield, and times of stages on a logarithmic axis.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::figures::{Yield, stages};
use super::markup::escaped;

/// Width of the plot of times, and of its names, pixels.
const WIDTH: f64 = 720.0;
const NAMES: f64 = 140.0;
/// Height of a row.
const ROW: f64 = 34.0;

/// A bar in three colours: accepted, rejected, failed.
pub(super) fn bar(of: Yield) -> String {
    let share = |n: u64| 100.0 * n as f64 / of.all().max(1) as f64;
    let parts = [("ok", of.accepted), ("no", of.rejected), ("bad", of.failed)];
    let parts = parts.map(|(class, n)| {
        if n == 0 {
            String::new()
        } else {
            format!("<i class={class} style=\"width:{:.2}%\"></i>", share(n))
        }
    });
    format!("<span class=bar>{}</span>", parts.concat())
}

/// The times of each stage: a dot at the median, a bar from the 10th to the 90th percentile, a
/// line from the least to the most.
pub(super) fn times(times: &BTreeMap<String, Vec<f64>>, ran: &BTreeMap<String, u64>) -> String {
    let all = || times.values().flatten().copied().filter(|t| *t > 0.0);
    let (least, most) = (all().fold(f64::MAX, f64::min), all().fold(0.0, f64::max));
    if most <= 0.0 {
        return "<p class=dim>No stage ran: everything was in the store.</p>".into();
    }
    let (low, high) = (least.log10().floor(), most.log10().ceil().max(least.log10().floor() + 1.0));
    let plot = WIDTH - NAMES - 90.0;
    let x = |t: f64| NAMES + plot * ((t.max(1e-9).log10() - low) / (high - low)).clamp(0.0, 1.0);
    let height = ROW * times.len() as f64 + 34.0;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {height}\" role=img aria-label=\"times of the stages\">"
    );
    let mut power = low;
    while power <= high {
        let at = x(10_f64.powf(power));
        let bottom = height - 26.0;
        let _ = write!(
            svg,
            "<line class=grid x1={at:.1} y1=0 x2={at:.1} y2={bottom:.1} /><text class=axis x={at:.1} y={:.1} text-anchor=middle>{}</text>",
            height - 8.0,
            seconds(10_f64.powf(power)),
        );
        power += 1.0;
    }
    let in_order = stages().filter_map(|stage| times.get_key_value(&stage));
    for (n, (stage, times)) in in_order.enumerate() {
        row(
            &mut svg,
            (n as f64 + 0.5) * ROW,
            stage,
            times,
            ran.get(stage).copied().unwrap_or(0),
            &x,
        );
    }
    svg + "</svg>"
}

fn row(svg: &mut String, y: f64, stage: &str, times: &[f64], ran: u64, x: &dyn Fn(f64) -> f64) {
    let at = |q: f64| x(quantile(times, q));
    let (name, end) = (escaped(stage), WIDTH - 80.0);
    let _ = write!(
        svg,
        "<text class=name x={:.1} y={:.1} text-anchor=end>{name}</text>",
        NAMES - 12.0,
        y + 4.0
    );
    let _ = write!(svg, "<line class=reach x1={:.1} y1={y} x2={:.1} y2={y} />", at(0.0), at(1.0));
    let width = (at(0.9) - at(0.1)).max(2.0);
    let _ = write!(
        svg,
        "<rect class=box x={:.1} y={:.1} width={width:.1} height=12 rx=3 />",
        at(0.1),
        y - 6.0
    );
    let _ = write!(svg, "<circle class=dot cx={:.1} cy={y} r=5 />", at(0.5));
    let median = seconds(quantile(times, 0.5));
    let _ = write!(
        svg,
        "<text class=value x={end:.1} y={:.1}>{median} <tspan class=axis>× {ran}</tspan></text>",
        y + 4.0
    );
}

/// A quantile of ascending numbers, 0 of none.
pub(super) fn quantile(ascending: &[f64], q: f64) -> f64 {
    let last = ascending.len().saturating_sub(1);
    ascending.get((q * last as f64).round() as usize).copied().unwrap_or(0.0)
}

/// A duration as people say it.
pub(super) fn seconds(t: f64) -> String {
    match t {
        t if t < 0.000_999_5 => format!("{:.0} µs", t * 1e6),
        t if t < 0.999_5 => format!("{:.0} ms", t * 1e3),
        t if t < 119.95 => format!("{} s", plain(t)),
        t => format!("{:.0} min", t / 60.0),
    }
}

/// A number with at most one digit behind the point.
fn plain(n: f64) -> String {
    let text = format!("{n:.1}");
    text.strip_suffix(".0").map_or(text.clone(), String::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_numbers_of_the_row() {
        let row = [1.0, 2.0, 3.0, 4.0, 10.0];
        assert_eq!([0.0, 0.5, 1.0].map(|q| quantile(&row, q)), [1.0, 3.0, 10.0]);
        assert_eq!(quantile(&[], 0.5), 0.0);
    }

    #[test]
    fn times_read_as_people_say_them() {
        let said = [2e-6, 0.004, 0.9999, 1.0, 12.34, 600.0].map(seconds);
        assert_eq!(said, ["2 µs", "4 ms", "1 s", "1 s", "12.3 s", "10 min"]);
    }

    #[test]
    fn a_bar_is_as_long_as_its_parts() {
        let text = bar(Yield { accepted: 3, rejected: 0, failed: 1 });
        assert_eq!(
            text,
            "<span class=bar><i class=ok style=\"width:75.00%\"></i><i class=bad style=\"width:25.00%\"></i></span>"
        );
    }
}
