//! Several pictures on one: a contact sheet.

use crate::ViewError;
use crate::raster::Picture;
use crate::visibility::NO_FACE;

/// Pixels between pictures, and around them.
pub const GUTTER: u32 = 8;
const PAPER: [u8; 4] = [255; 4];

/// Lays pictures out row by row in `columns` columns, each in the middle of a cell that holds the
/// largest; depth and faces travel along.
///
/// # Errors
/// [`ViewError::EmptySheet`] without pictures or columns.
pub fn contact_sheet(pictures: &[Picture], columns: usize) -> Result<Picture, ViewError> {
    if pictures.is_empty() || columns == 0 {
        return Err(ViewError::EmptySheet);
    }
    let columns = columns.min(pictures.len());
    let rows = pictures.len().div_ceil(columns);
    let most = |axis: usize| pictures.iter().map(|p| p.size[axis]).max().unwrap_or(0);
    let cell = [most(0), most(1)];
    let side = |cells: usize, axis: usize| cells as u32 * (cell[axis] + GUTTER) + GUTTER;
    let mut sheet = Picture::blank([side(columns, 0), side(rows, 1)], PAPER);
    for (i, picture) in pictures.iter().enumerate() {
        let place = [i % columns, i / columns];
        let corner = std::array::from_fn(|axis| {
            side(place[axis], axis) + (cell[axis] - picture.size[axis]) / 2
        });
        paste(&mut sheet, picture, corner);
    }
    Ok(sheet)
}

fn paste(sheet: &mut Picture, picture: &Picture, [left, top]: [u32; 2]) {
    let [width, height] = picture.size;
    for y in 0..height {
        for x in 0..width {
            let (Some(from), Some(to)) = (picture.index([x, y]), sheet.index([left + x, top + y]))
            else {
                continue;
            };
            sheet.colour[to] = picture.colour.get(from).copied().unwrap_or(PAPER);
            sheet.depth[to] = picture.depth.get(from).copied().unwrap_or(f32::INFINITY);
            sheet.face[to] = picture.face.get(from).copied().unwrap_or(NO_FACE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_pictures_in_three_columns_take_two_rows() {
        let picture = |i: u8| Picture::blank([7, 5], [i, i, i, 255]);
        let pictures: Vec<_> = (0..5).map(picture).collect();
        let sheet = contact_sheet(&pictures, 3).unwrap();
        assert_eq!(sheet.size, [3 * 15 + 8, 2 * 13 + 8]);
        let at = |x, y| sheet.colour[sheet.index([x, y]).unwrap()][0];
        assert_eq!((at(8, 8), at(8 + 15 + 6, 8 + 13 + 4), at(0, 0)), (0, 4, 255));
        assert_eq!(contact_sheet(&pictures, 0), Err(ViewError::EmptySheet));
        assert_eq!(contact_sheet(&[], 3), Err(ViewError::EmptySheet));
        assert_eq!(contact_sheet(&pictures[..1], 9).unwrap().size, [23, 21]);
    }
}
