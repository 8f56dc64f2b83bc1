//! Rectangles that contain all that changes in a picture.

/// Upper left corner and size of the stored part of a frame [pixels].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub(crate) left: usize,
    pub(crate) top: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Patch {
    /// Bounding rectangle of all changed pixels of pictures of `width` columns; None if none has changed.
    pub(crate) fn between(before: &[[u8; 4]], now: &[[u8; 4]], width: usize) -> Option<Self> {
        let rows = || now.chunks_exact(width).zip(before.chunks_exact(width));
        let top = rows().position(|(now, before)| now != before)?;
        let bottom = rows().rposition(|(now, before)| now != before).map_or(top, |row| row + 1);
        let (mut left, mut right) = (width, 0);
        for (now, before) in rows().take(bottom).skip(top) {
            let differs = |(p, q): (&[u8; 4], &[u8; 4])| p != q;
            left = now[..left].iter().zip(&before[..left]).position(differs).unwrap_or(left);
            let beyond = now[right..].iter().zip(&before[right..]).rposition(differs);
            right = beyond.map_or(right, |offset| right + offset + 1);
        }
        Some(Self { left, top, width: right - left, height: bottom - top })
    }

    /// Bounding rectangle of the pixels for which a function of column and row of this patch is true; one pixel if there is none.
    pub(crate) fn within(&self, chosen: impl Fn(usize, usize) -> bool) -> Self {
        let (columns, rows) = (0..self.width, 0..self.height);
        let in_row = |&row: &usize| columns.clone().any(|column| chosen(column, row));
        let (Some(top), Some(bottom)) = (rows.clone().find(in_row), rows.rev().find(in_row)) else {
            return Self { width: 1, height: 1, ..*self };
        };
        let (mut left, mut right) = (self.width, 0);
        for row in top..=bottom {
            left = (0..left).find(|&column| chosen(column, row)).unwrap_or(left);
            right = (right..self.width).rev().find(|&column| chosen(column, row)).map_or(right, |column| column + 1);
        }
        Self { left: self.left + left, top: self.top + top, width: right - left, height: bottom + 1 - top }
    }
}
