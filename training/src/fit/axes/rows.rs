//! Joints in bytes, so that they are not read again: numbers in single precision, little-endian; of each
//! joint its share, sight, kind, weight and count of candidates, then of each candidate its offsets, its
//! share of the truth and its features.

use model::classic::joints::axis_model::INPUTS;

use super::joint::{Joint, SIGHTS};
use crate::forest::Question;

/// All of them.
pub(super) fn write(joints: &[Joint]) -> Vec<u8> {
    let mut to = Vec::new();
    let mut put = |values: &[f32]| values.iter().for_each(|v| to.extend(v.to_le_bytes()));
    put(&[INPUTS as f32, joints.len() as f32]);
    for joint in joints {
        let Joint { share, sight, turns, asked, off } = joint;
        let turns = f32::from(u8::from(*turns));
        put(&[*share as f32, *sight as f32, turns, asked.weight, off.len() as f32]);
        for ((off, truth), numbers) in off.iter().zip(&asked.truth).zip(&asked.numbers) {
            put(&[off.0, off.1, *truth]);
            put(numbers);
        }
    }
    to
}

/// What [`write()`] wrote; nothing where it is not that.
pub(super) fn read(bytes: &[u8]) -> Option<Vec<Joint>> {
    let (values, rest) = bytes.as_chunks::<4>();
    let values: Vec<f32> = values.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let mut from = &values[..];
    let [numbers, count] = take(&mut from)?;
    if numbers as usize != INPUTS || !rest.is_empty() {
        return None;
    }
    let joints = (0..count as usize).map(|_| joint(&mut from)).collect::<Option<Vec<_>>>()?;
    from.is_empty().then_some(joints)
}

fn joint(from: &mut &[f32]) -> Option<Joint> {
    let [share, sight, turns, weight, count] = take(from)?;
    let (mut off, mut truth, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..count as usize {
        let [angle, line, share] = take(from)?;
        off.push((angle, line));
        truth.push(share);
        numbers.push(take::<INPUTS>(from)?);
    }
    let asked = Question { weight, truth, numbers };
    let sight = Some(sight as usize).filter(|s| *s < SIGHTS.len())?;
    Some(Joint { share: share as usize, sight, turns: turns > 0.5, asked, off })
}

fn take<const N: usize>(from: &mut &[f32]) -> Option<[f32; N]> {
    let (values, rest) = from.split_first_chunk()?;
    *from = rest;
    Some(*values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_are_read_as_they_were_written_and_torn_ones_not_at_all() {
        let numbers = vec![[0.5; INPUTS], [-2.0; INPUTS]];
        let asked = Question { weight: 0.25, truth: vec![0.0, 1.0], numbers };
        let off = vec![(90.0, 0.5), (1.0, 0.125)];
        let joints = [
            Joint { share: 2, sight: 5, turns: true, asked: asked.clone(), off },
            Joint {
                share: 0,
                sight: 0,
                turns: false,
                asked: Question { truth: vec![], numbers: vec![], ..asked },
                off: vec![],
            },
        ];
        let bytes = write(&joints);
        assert_eq!(read(&bytes).unwrap(), joints);
        assert_eq!(read(&bytes[..bytes.len() - 4]), None);
        assert_eq!(read(&[&bytes[..], &[0; 4]].concat()), None);
        assert_eq!(read(b"none"), None);
    }
}
