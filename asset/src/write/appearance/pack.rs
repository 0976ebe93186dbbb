//! Rectangles laid side by side on a sheet.

/// A rectangle's width and height, pixels.
pub(crate) type Size = [u32; 2];

/// Where each rectangle's upper left corner comes to lie, and the size of the sheet: highest first, in
/// rows. Order and sheet depend on the sizes alone.
pub(crate) fn packed(sizes: &[Size]) -> (Vec<[u32; 2]>, Size) {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(sizes[i][1]), std::cmp::Reverse(sizes[i][0]), i));
    let area: f64 = sizes.iter().map(|s| f64::from(s[0]) * f64::from(s[1])).sum();
    let widest = sizes.iter().map(|s| s[0]).max().unwrap_or(0);
    let width = widest.max(area.sqrt().ceil() as u32);
    let mut places = vec![[0, 0]; sizes.len()];
    let ([mut x, mut y], mut row) = ([0, 0], 0);
    for index in order {
        let [w, h] = sizes[index];
        if x > 0 && x + w > width {
            (x, y, row) = (0, y + row, 0);
        }
        places[index] = [x, y];
        (x, row) = (x + w, row.max(h));
    }
    (places, [width, y + row])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_lie_apart_and_on_the_sheet() {
        let sizes: Vec<Size> = (1..40).map(|n| [1 + n * 7 % 23, 1 + n * 5 % 17]).collect();
        let (places, sheet) = packed(&sizes);
        let ends = |i: usize| [0, 1].map(|k| places[i][k] + sizes[i][k]);
        for i in 0..sizes.len() {
            assert!(ends(i)[0] <= sheet[0] && ends(i)[1] <= sheet[1]);
            for j in 0..i {
                let apart = |k: usize| ends(i)[k] <= places[j][k] || ends(j)[k] <= places[i][k];
                assert!(apart(0) || apart(1), "{i} {j}");
            }
        }
        let area: u32 = sizes.iter().map(|s| s[0] * s[1]).sum();
        assert!(f64::from(sheet[0] * sheet[1]) < 1.4 * f64::from(area));
        assert_eq!(packed(&[]), (vec![], [0, 0]));
    }
}
