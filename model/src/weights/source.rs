//! A safetensors file as the source of a network's parameters.

use std::io::{Read, Seek};

use super::file::{TensorFile, WeightsError};
use crate::net::source::{Source, Start};

/// Gives a network its parameters; the first failure is kept and ends the loading.
#[derive(Debug)]
pub(crate) struct FileSource<'a, R> {
    pub(crate) file: &'a mut TensorFile<R>,
    pub(crate) failure: Option<WeightsError>,
}

impl<R: Read + Seek> Source for FileSource<'_, R> {
    fn values(&mut self, name: &str, shape: &[usize], _: Start) -> Vec<f32> {
        let finite = |values: Vec<f32>| {
            let sound = values.iter().all(|v| v.is_finite());
            sound.then_some(values).ok_or_else(|| WeightsError::NotFinite(name.into()))
        };
        match self.file.values(name).and_then(finite) {
            Ok(values) => values,
            Err(failure) => {
                self.failure.get_or_insert(failure);
                vec![0.0; shape.iter().product()]
            }
        }
    }
}
