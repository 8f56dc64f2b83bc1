//! Differences between successive pictures of palette indices.

use std::ops::Range;

use crate::lzw::TRANSPARENT;

/// Minimum length of runs of unchanged pixels that become transparent. Shorter runs would break the repeated strings around them.
/// With `benches/film.py` the file grows by 2 % if every unchanged pixel is transparent.
const SHORTEST_RUN: usize = 32;

/// Number of pixels compared at once. A run of at least twice this length, less one, contains an aligned group of this length.
const GROUP: usize = 16;
const _: () = assert!(SHORTEST_RUN >= 2 * GROUP - 1);

/// Upper left corner and size of the stored part of a frame [pixels].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub(crate) left: usize,
    pub(crate) top: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Patch {
    /// Bounding rectangle of all changed pixels; one pixel if none has changed.
    pub(crate) fn between(before: &[u8], now: &[u8], width: usize) -> Self {
        let rows = || now.chunks_exact(width).zip(before.chunks_exact(width));
        let Some(top) = rows().position(|(now, before)| now != before) else {
            return Self { left: 0, top: 0, width: 1, height: 1 };
        };
        let bottom = rows().rposition(|(now, before)| now != before).map_or(top, |row| row + 1);
        let (mut left, mut right) = (width, 0);
        for (now, before) in rows().take(bottom).skip(top) {
            let differs = |(p, q): (&u8, &u8)| p != q;
            left = now[..left].iter().zip(&before[..left]).position(differs).unwrap_or(left);
            let beyond = now[right..].iter().zip(&before[right..]).rposition(differs);
            right = beyond.map_or(right, |offset| right + offset + 1);
        }
        Self { left, top, width: right - left, height: bottom - top }
    }

    /// Copies this part of a picture of `width` columns to `out`.
    pub(crate) fn cut(&self, picture: &[u8], width: usize, out: &mut Vec<u8>) {
        out.clear();
        for row in picture.chunks_exact(width).skip(self.top).take(self.height) {
            out.extend_from_slice(&row[self.left..][..self.width]);
        }
    }

    /// Writes the symbols of the patch to a picture of `width` columns, except transparent ones.
    pub(crate) fn paste(&self, symbols: &[u8], width: usize, picture: &mut [u8]) {
        let rows = picture.chunks_exact_mut(width).skip(self.top);
        for (row, symbols) in rows.zip(symbols.chunks_exact(self.width)) {
            for (pixel, &symbol) in row[self.left..].iter_mut().zip(symbols) {
                *pixel = if symbol == TRANSPARENT { *pixel } else { symbol };
            }
        }
    }

    /// Makes long runs of unchanged pixels of a patch transparent; returns the number of these pixels.
    pub(crate) fn clear_unchanged(&self, before: &[u8], width: usize, symbols: &mut [u8]) -> usize {
        let rows = before.chunks_exact(width).skip(self.top).map(|row| &row[self.left..][..self.width]);
        let mut cleared = 0;
        for (now, before) in symbols.chunks_exact_mut(self.width).zip(rows) {
            let mut column = 0;
            while let Some(run) = next_run(now, before, column) {
                column = run.end;
                if run.len() >= SHORTEST_RUN {
                    cleared += run.len();
                    now[run].fill(TRANSPARENT);
                }
            }
        }
        cleared
    }
}

/// First run of equal pixels from `start` on that contains a whole aligned group, as every long run does.
fn next_run(now: &[u8], before: &[u8], start: usize) -> Option<Range<usize>> {
    let group = start.div_ceil(GROUP);
    let ((groups, _), (others, _)) = (now.as_chunks::<GROUP>(), before.as_chunks::<GROUP>());
    let equal = (group..groups.len()).find(|&group| groups[group] == others[group])?;
    let inside = equal * GROUP;
    let differs = |(p, q): (&u8, &u8)| p != q;
    let back = now[start..inside].iter().zip(&before[start..inside]).rposition(differs);
    let same = |(p, q): &(&u8, &u8)| p == q;
    let onward = now[inside..].iter().zip(&before[inside..]).take_while(same).count();
    Some(back.map_or(start, |offset| start + offset + 1)..inside + onward)
}
