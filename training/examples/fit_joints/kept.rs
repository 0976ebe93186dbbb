//! Joints' numbers in a file, so that trees and networks can be fitted again without reading the objects
//! again: little-endian, of each joint its share, sight, kind, weight and count of candidates, then of
//! each candidate its offsets, its share of the truth and its numbers.

use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;

use model::geometric::score::NUMBERS;
use training::forest::Question;

use super::{Anyhow, Joint};

/// Writes them all, or nothing.
pub(super) fn write(path: &Path, joints: &[Joint]) -> Result<(), Anyhow> {
    let partial = path.with_extension("partial");
    let mut to = BufWriter::new(std::fs::File::create(&partial)?);
    put(&mut to, &[NUMBERS as f32, joints.len() as f32])?;
    for joint in joints {
        let Joint { share, sight, turns, asked, off } = joint;
        let turns = f32::from(u8::from(*turns));
        put(&mut to, &[*share as f32, *sight as f32, turns, asked.weight, off.len() as f32])?;
        for ((off, truth), numbers) in off.iter().zip(&asked.truth).zip(&asked.numbers) {
            put(&mut to, &[off.0, off.1, *truth])?;
            put(&mut to, numbers)?;
        }
    }
    to.flush()?;
    Ok(std::fs::rename(partial, path)?)
}

/// Reads what [`write`] wrote, by a program whose candidates have as many numbers.
pub(super) fn read(path: &Path) -> Result<Vec<Joint>, Anyhow> {
    let mut from = BufReader::new(std::fs::File::open(path)?);
    let [numbers, count] = take(&mut from)?;
    if numbers as usize != NUMBERS {
        return Err(format!("{}: {numbers} numbers, not {NUMBERS}", path.display()).into());
    }
    (0..count as usize).map(|_| joint(&mut from)).collect()
}

fn joint(from: &mut impl Read) -> Result<Joint, Anyhow> {
    let [share, sight, turns, weight, count] = take(from)?;
    let (mut off, mut truth, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..count as usize {
        let [angle, line, share] = take(from)?;
        off.push((angle, line));
        truth.push(share);
        numbers.push(take::<NUMBERS>(from)?);
    }
    let asked = Question { weight, truth, numbers };
    Ok(Joint { share: share as usize, sight: sight as usize, turns: turns > 0.5, asked, off })
}

fn put(to: &mut impl Write, values: &[f32]) -> Result<(), Anyhow> {
    values.iter().try_for_each(|v| to.write_all(&v.to_le_bytes()))?;
    Ok(())
}

fn take<const N: usize>(from: &mut impl Read) -> Result<[f32; N], Anyhow> {
    let mut values = [0.0; N];
    for value in &mut values {
        let mut bytes = [0; 4];
        from.read_exact(&mut bytes)?;
        *value = f32::from_le_bytes(bytes);
    }
    Ok(values)
}
