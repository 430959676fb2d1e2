//! Pictures side by side.

use crate::Picture;

/// Pixels between two pictures.
const GAP: u32 = 4;

/// Behind and between the pictures.
const GROUND: [u8; 3] = [24, 26, 30];

/// One picture of many of the same size, `columns` in each row, in their order.
pub fn sheet(pictures: &[Picture], columns: u32) -> Picture {
    let columns = columns.max(1);
    let Some(Picture { width, height, .. }) = pictures.first() else {
        return Picture { width: 0, height: 0, pixels: Vec::new() };
    };
    let rows = (pictures.len() as u32).div_ceil(columns);
    let size = |side: u32, count: u32| side * count + GAP * (count + 1);
    let (across, down) = (size(*width, columns), size(*height, rows));
    let mut pixels = vec![GROUND; across as usize * down as usize];
    for (k, picture) in (0..).zip(pictures) {
        let (left, top) = (GAP + (width + GAP) * (k % columns), GAP + (height + GAP) * (k / columns));
        for (row, line) in (top..).zip(picture.pixels.chunks_exact(*width as usize)).take(*height as usize) {
            let start = row as usize * across as usize + left as usize;
            pixels[start..start + line.len()].copy_from_slice(line);
        }
    }
    Picture { width: across, height: down, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_picture_is_in_its_place() {
        let one = |k: u8| Picture { width: 3, height: 2, pixels: vec![[k, 0, 0]; 6] };
        let all = sheet(&[one(1), one(2), one(3)], 2);
        assert_eq!((all.width, all.height), (2 * 3 + 3 * GAP, 2 * 2 + 3 * GAP));
        let at = |x: u32, y: u32| all.pixels[(y * all.width + x) as usize];
        assert_eq!(
            [at(GAP, GAP), at(2 * GAP + 5, GAP + 1), at(GAP + 2, 2 * GAP + 3)],
            [[1, 0, 0], [2, 0, 0], [3, 0, 0]]
        );
        assert_eq!([at(0, 0), at(2 * GAP + 3, 2 * GAP + 2)], [GROUND; 2]);
        assert!(sheet(&[], 3).pixels.is_empty());
    }
}
