//! What chooses joint axes: boosted trees and a small network, each for turns and for slides.
//!
//! Every object is seen four times: as it is and fused, with its true labels and with found ones.
//! Labels are seldom perfect, so found ones come from the packs that ship, out of fold. Fused
//! meshes are also seen with hinges whose knuckles all belong to one side. Objects of validation
//! are labelled as the program does it. Candidates near the true axis of a joint count as right;
//! for trees, the nearer the more. What is read is kept shard by shard, so a run that was ended
//! goes on reading where it was.

mod joint;
mod knuckles;
mod net;
mod rows;

use model::classic::joints::axis_model::{
    FOLDS, INPUTS, JOINTS, KIND, OF_NETS, OF_TREES, blended, forest_section, names, net_section,
};
use model::classic::joints::features::{COUNT, NAMES};
use model::classic::learned::forest::{Forest, mean_chances};
use model::classic::learned::network::Net;
use model::classic::learned::pack::{Ensemble, Form, Section, Table};
use model::classic::segment::Way;
use serde::Deserialize;

use super::data::{Split, Subject, of_ids, together};
use super::recipe::{Families, Model};
use super::{Bench, FitError, Fits, Fitted};
use crate::forest::{Bins, Growth, Lessons, fold_number, left_out_fold};
use crate::fuse;
use joint::{Joint, SIGHTS, WRONG, best, nearest};

/// A seed that nothing else is made with.
const FAMILY_SEED: u64 = 52;
/// Objects fall into so many shares: fold `f` leaves out number `f % SHARES`, so that several folds know
/// the same objects and differ by their seeds.
const SHARES: usize = 3;
/// Bins are chosen by every so many joints.
const SAMPLED: usize = 4;

/// How axes are fitted: the table `model` of a recipe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// At most so many objects of the shards; all where it is not given.
    #[serde(default)]
    pub objects: Option<usize>,
    /// How objects are fused.
    pub fused: fuse::Recipe,
    /// Objects of our own families.
    #[serde(default)]
    pub families: Families,
    /// How trees grow.
    pub growth: Growth,
}

impl Model for Axes {
    fn families(&self) -> Vec<&Families> {
        vec![&self.families]
    }

    fn check(&self) -> Result<(), String> {
        self.growth.check().map_err(|what| format!("model.growth: {what}"))
    }
}

impl Fits for Axes {
    const READS: &'static [&'static str] =
        &["contacts", "sizes", "roles", "fused_unary", "segments", "segments_fused"];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError> {
        let train = self.train(bench)?;
        let validation = self.of_shards(Split::Validation, bench)?;
        let tables = vec![Table::new(OF_TREES, names()), Table::new(OF_NETS, NAMES)];
        let mut fitted = Fitted::of(KIND, tables);
        for (turns, name) in JOINTS.into_iter().enumerate() {
            let own: Vec<&Joint> = train.iter().filter(|j| usize::from(j.turns) == turns).collect();
            if !own.iter().any(|j| j.is_told()) {
                return Err(FitError::Nothing("the axes of turns and slides"));
            }
            let judged = validation.iter().filter(|j| usize::from(j.turns) == turns);
            let judged: Vec<&Joint> = judged.collect();
            let (forests, net) = self.models(name, &own, bench)?;
            for (fold, forest) in forests.iter().enumerate() {
                let mut bytes = Vec::new();
                forest.write(&mut bytes);
                let section = Section::new(forest_section(name, fold), OF_TREES, Form::Forest);
                fitted.sections.push((section, bytes));
            }
            let section = Section::new(net_section(name), OF_NETS, Form::Single);
            fitted.sections.push((section, net.write()));
            fitted.ensembles.push(Ensemble { folds: forests.len(), rounds: 1 });
            tell(name, (&own, &judged), (&forests, &net), (bench, &mut fitted));
        }
        Ok(fitted)
    }
}

impl Axes {
    /// A forest for each fold, and the network.
    fn models(
        &self,
        name: &str,
        own: &[&Joint],
        bench: &Bench<'_>,
    ) -> Result<(Vec<Forest<INPUTS>>, Net), FitError> {
        let net = net::fitted(&format!("{name}, network"), own, bench)?;
        let bins = Bins::of(own.iter().step_by(SAMPLED).flat_map(|j| &j.asked.numbers));
        let mut lessons = Lessons::new(&bins);
        own.iter().for_each(|j| lessons.add(std::slice::from_ref(&j.asked)));
        let grow = |fold: usize| {
            let growth = Growth { seed: self.growth.seed + fold as u64, ..self.growth };
            let knows = |joint: usize| own[joint].share != fold % SHARES && own[joint].is_told();
            bench.kept.forest(&forest_section(name, fold), (&lessons, &growth), knows)
        };
        Ok(((0..FOLDS).map(grow).collect::<Result<_, _>>()?, net))
    }

    fn train(&self, bench: &Bench<'_>) -> Result<Vec<Joint>, FitError> {
        let mut joints = self.of_shards(Split::Train, bench)?;
        for ids in together(&self.families) {
            let what = format!("families from {}", ids[0]);
            let made = || of_ids(&ids, FAMILY_SEED, |s| self.seen(s, Split::Train));
            let of = format!("{FAMILY_SEED} {ids:?}");
            joints.extend(self.kept((&what, of.as_bytes()), bench, made)?);
        }
        if joints.is_empty() { Err(FitError::Nothing("axes")) } else { Ok(joints) }
    }

    fn of_shards(&self, split: Split, bench: &Bench<'_>) -> Result<Vec<Joint>, FitError> {
        let (mut joints, mut left) = (Vec::new(), self.objects.unwrap_or(usize::MAX));
        for shard in bench.data.shards(split)? {
            if left == 0 {
                break;
            }
            let what = super::data::called(&shard);
            let bytes = std::fs::read(&shard).map_err(FitError::io(&shard))?;
            let of = [&bytes[..], &left.to_le_bytes()].concat();
            // How many objects there are is known without what is told of them.
            let objects = crate::dataset::shards::read_shard(&shard)?.len().min(left);
            let made =
                || Ok(bench.data.of_shard((&shard, split), left, |s| self.seen(s, split))?.1);
            joints.extend(self.kept((&what, &of), bench, made)?);
            left -= objects;
        }
        Ok(joints)
    }

    /// Joints as they were kept, or as they are made, and then kept; `what` says in a word, and with `of`
    /// in full, whose they are.
    fn kept(
        &self,
        (what, of): (&str, &[u8]),
        bench: &Bench<'_>,
        make: impl FnOnce() -> Result<Vec<Joint>, FitError>,
    ) -> Result<Vec<Joint>, FitError> {
        let mut inputs = bench.inputs(&format!("{what} {:?}", self.fused));
        inputs.update(of);
        let found = bench.kept.find(what, &inputs).and_then(|bytes| rows::read(&bytes));
        let joints = match found {
            Some(joints) => joints,
            None => {
                let joints = make()?;
                bench.kept.keep(what, &inputs, &rows::write(&joints))?;
                joints
            }
        };
        bench.watcher.say(&format!("{what}: {} joints", joints.len()));
        Ok(joints)
    }

    /// The joints of an object in all of [`SIGHTS`].
    fn seen(&self, subject: &Subject, split: Split) -> Vec<Joint> {
        let Subject { specimen, category } = subject;
        let share = left_out_fold(&specimen.id, SHARES);
        let way = match split {
            Split::Validation => Way::Fitted,
            // Labels by the fold that does not know the object.
            Split::Train => Way::OutOfFold(fold_number(&specimen.id)),
        };
        let fused = fuse::fused(specimen, &self.fused).map(|s| s.object);
        let sights = [Some(specimen.object.clone()), fused.ok()].into_iter().enumerate();
        let seen = sights.flat_map(|(i, o)| o.map(|o| (i, o)));
        seen.flat_map(|(i, o)| joint::seen_as(&o, category, (2 * i, share, way))).collect()
    }
}

/// Reports on each sight of the joints, and takes what validation says for the pack.
fn tell(
    name: &str,
    (own, judged): (&[&Joint], &[&Joint]),
    (forests, net): (&[Forest<INPUTS>], &Net),
    (bench, fitted): (&Bench<'_>, &mut Fitted),
) {
    let likeliest = |forests: &[Forest<INPUTS>], joint: &Joint| {
        let chances = mean_chances(forests, &joint.asked.numbers);
        best(&chances.into_iter().map(f64::from).collect::<Vec<_>>())
    };
    let both = |joint: &Joint| {
        let chances = mean_chances(forests, &joint.asked.numbers);
        best(&blended(&chances, &net_scores(net, joint)))
    };
    let mut told = |what: &str, joints: &[&Joint], chosen: &dyn Fn(&Joint) -> usize| {
        for (sight, seen) in SIGHTS.iter().enumerate() {
            let joints: Vec<&Joint> = joints.iter().copied().filter(|j| j.sight == sight).collect();
            let what = format!("{name}, {what}, {seen}");
            if let Some([near, found]) = report(bench, &what, &joints, chosen) {
                let [near_name, found_name] = ["within 15 degrees", "within 15 degrees and 0.05"]
                    .map(|m| format!("{what}: {m}"));
                fitted.metrics.extend([(near_name, near), (found_name, found)]);
            }
        }
    };
    told("out of fold by the trees", own, &|j| likeliest(&forests[j.share..=j.share], j));
    told("validation by the network", judged, &|j| best(&net_scores(net, j)));
    told("validation by the trees", judged, &|j| likeliest(forests, j));
    told("validation by both", judged, &both);
    told("validation, the nearest there is", judged, &nearest);
}

/// What the network says of each candidate.
fn net_scores(net: &Net, joint: &Joint) -> Vec<f64> {
    let Some((role, is_endless)) = joint.told() else { return Vec::new() };
    let numbers = joint.asked.numbers.iter().map(joint::own);
    numbers.map(|row: [f64; COUNT]| net.score(&row, role, is_endless)).collect()
}

/// The shares of joints whose chosen axis is near by angle, and by angle and distance; 0 to 1.
fn report(
    bench: &Bench<'_>,
    what: &str,
    joints: &[&Joint],
    chosen: impl Fn(&Joint) -> usize,
) -> Option<[f64; 2]> {
    if joints.is_empty() {
        return None;
    }
    let count = joints.len() as f64;
    let (mut near, mut found, mut angle, mut line) = (0.0, 0.0, 0.0, 0.0);
    for joint in joints {
        let Some(&(a, l)) = joint.off.get(chosen(joint)) else { continue };
        let (a, l) = (f64::from(a), f64::from(l));
        near += f64::from(u8::from(a < WRONG.0)) / count;
        found += f64::from(u8::from(a < WRONG.0 && l < WRONG.1)) / count;
        angle += a / count;
        line += l / count;
    }
    bench.watcher.say(&format!(
        "{what}: {count} joints, {:.1} % near, {:.1} % found, {angle:.1}°, {line:.4}",
        100.0 * near,
        100.0 * found
    ));
    Some([near, found])
}
