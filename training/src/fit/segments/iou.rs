//! Intersection over union of parts, from the areas that they share.

/// Mean IoU over parts, from the area of each true part that has each label.
pub(super) fn mean_iou(crossed: &[Vec<f64>]) -> f64 {
    let one = |p: usize| {
        let own: f64 = crossed[p].iter().sum();
        let taken: f64 = crossed.iter().map(|row| row[p]).sum();
        crossed[p][p] / (own + taken - crossed[p][p]).max(1e-12)
    };
    (0..crossed.len()).map(one).sum::<f64>() / crossed.len() as f64
}
