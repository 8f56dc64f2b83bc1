//! LZW compression with tolerance: each pixel may have one of several colors, and the longest known string of such colors is
//! used.
//!
//! The idea is that of `gifsicle --lossy` (K. Lesiński, 2014). Here the error is bounded for each pixel separately, so errors
//! neither add up nor spread.

use crate::color::Rgb;
use crate::lzw::{Codes, GREATEST_CODE, Slots, TRANSPARENT, find, free_slots, key};

/// Number of strings tried at each position without finding a longer one.
const TRIALS: usize = 24;

/// First row of [`Tolerance`] whose entries allow a single color only.
const EXACT: u16 = 256;

/// Table of the palette colors that may replace each color.
#[derive(Clone, Debug)]
pub(crate) struct Tolerance {
    /// Table of 2 · 256 rows of 256 entries.
    allowed: Vec<bool>,
    /// Allowed colors of each row, the nearest last.
    ordered: Vec<Vec<u8>>,
}

impl Tolerance {
    /// Builds the table: colors at most `distance` apart may replace each other. Green counts twice as much as red and four times
    /// as much as blue. The first `reserved` colors are replaced by none, so backgrounds stay clean.
    pub(crate) fn new(colors: &[Rgb], reserved: usize, distance: u8) -> Self {
        let mut table = Self { allowed: vec![false; 2 * 256 * 256], ordered: vec![Vec::new(); 2 * 256] };
        for (row, color) in colors.iter().enumerate() {
            let mut near: Vec<(u32, u8)> = (1..=u8::MAX)
                .zip(colors)
                .map(|(number, other)| (squared_distance(*color, *other), number))
                .filter(|&(squared, number)| {
                    usize::from(number) == row + 1
                        || row >= reserved && usize::from(number) > reserved && squared <= u32::from(distance).pow(2)
                })
                .collect();
            near.sort_unstable_by(|p, q| q.cmp(p));
            table.allow(row + 1, near.iter().map(|&(_, number)| number).collect());
            table.allow(usize::from(EXACT) + row + 1, vec![(row + 1) as u8]);
        }
        table
    }

    fn allow(&mut self, row: usize, numbers: Vec<u8>) {
        numbers.iter().for_each(|&number| self.allowed[row << 8 | usize::from(number)] = true);
        self.ordered[row] = numbers;
    }

    /// Whether a color may replace another one.
    pub(crate) fn allows(&self, wanted: u8, shown: u8) -> bool {
        self.allowed[usize::from(wanted) << 8 | usize::from(shown)]
    }
}

/// Squared color distance, weighted approximately as the eye weighs channels: 6/7, 12/7 and 3/7 of each square.
fn squared_distance(p: Rgb, q: Rgb) -> u32 {
    let [red, green, blue] = [0, 1, 2].map(|channel| u32::from(p[channel].abs_diff(q[channel])).pow(2));
    3 * (2 * red + 4 * green + blue) / 7
}

/// Set of colors that a pixel may have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    row: u16,
    keep: bool,
}

impl Wish {
    /// Allows a color and its replacements; with `keep` also the color on the screen.
    pub(crate) fn about(wanted: u8, keep: bool) -> Self {
        Self { row: u16::from(wanted), keep }
    }

    /// Allows only the color on the screen.
    pub(crate) fn rest(shown: u8) -> Self {
        Self { row: EXACT + u16::from(shown), keep: true }
    }

    #[inline(always)]
    fn takes(self, tolerance: &Tolerance, symbol: u8) -> bool {
        if symbol == TRANSPARENT { self.keep } else { tolerance.allowed[usize::from(self.row) << 8 | usize::from(symbol)] }
    }
}

const NONE: u16 = u16::MAX;
const CODES: usize = GREATEST_CODE as usize + 1;

/// Encoder of wishes; its memory is reused from frame to frame.
pub(crate) struct TolerantEncoder {
    /// Tree of strings. Each string has a last symbol, a prefix (parent), a first longer string (child), and a next string with
    /// the same prefix (sibling).
    symbol: Vec<u8>,
    parent: Vec<u16>,
    child: Vec<u16>,
    sibling: Vec<u16>,
    /// Number of strings that are longer by one symbol. The slots hold these by string and symbol, as in
    /// [`Encoder`](crate::lzw::Encoder).
    children: Vec<u16>,
    slots: Box<Slots>,
    stack: Vec<(u16, usize)>,
    string: Vec<u8>,
    bytes: Vec<u8>,
}

impl TolerantEncoder {
    pub(crate) fn new() -> Self {
        let links = || vec![NONE; CODES];
        let symbol = (0..CODES).map(|code| code as u8).collect();
        let (stack, string, bytes) = (Vec::new(), Vec::new(), Vec::new());
        let (children, slots) = (vec![0; CODES], free_slots());
        Self { symbol, parent: links(), child: links(), sibling: links(), children, slots, stack, string, bytes }
    }

    /// Appends the code size and the sub-blocks for symbols that fulfill `wishes` to `out`, and writes the symbols to `symbols`.
    /// All symbols are below 2^`bits`.
    pub(crate) fn encode(&mut self, wishes: &[Wish], tolerance: &Tolerance, bits: u32, symbols: &mut Vec<u8>, out: &mut Vec<u8>) {
        let bits = bits.max(2);
        let (clear, end) = (1 << bits, (1 << bits) + 1);
        let mut bytes = std::mem::take(&mut self.bytes);
        let mut codes = Codes::new(&mut bytes, bits);
        let mut next = end + 1;
        let mut before: Option<u16> = None;
        self.forget();
        codes.write(clear);
        symbols.clear();
        while symbols.len() < wishes.len() {
            let ahead = &wishes[symbols.len()..];
            let (mut code, length) = self.longest(ahead, tolerance);
            // The string that the decoder learns from this very code: the previous string and its first symbol.
            let repeats = before.is_some() && self.repeats(ahead, tolerance, length);
            if repeats {
                code = next as u16;
                self.string.push(self.string[0]);
            } else {
                self.spell(code, length);
            }
            if let Some(before) = before {
                self.learn(next as u16, before, self.string[0]);
                next += 1;
            }
            codes.write(u32::from(code));
            symbols.extend_from_slice(&self.string);
            before = Some(code);
            if next > GREATEST_CODE {
                codes.write(clear);
                self.forget();
                (next, before) = (end + 1, None);
            } else {
                codes.widen(next);
            }
        }
        codes.finish(end, out);
        self.bytes = bytes;
    }

    fn forget(&mut self) {
        self.child.fill(NONE);
        self.sibling.fill(NONE);
        self.children.fill(0);
        self.slots.fill(0);
    }

    /// Finds the longest string, among those tried, that fits the pixels ahead; returns its code and its length.
    fn longest(&mut self, ahead: &[Wish], tolerance: &Tolerance) -> (u16, usize) {
        let first = ahead[0];
        let roots = &tolerance.ordered[usize::from(first.row)];
        let mut best = (u16::from(roots.last().copied().unwrap_or(TRANSPARENT)), 1);
        self.stack.clear();
        self.stack.extend(roots.iter().map(|&root| (u16::from(root), 1)));
        if first.keep {
            self.stack.push((u16::from(TRANSPARENT), 1));
            best.0 = u16::from(TRANSPARENT);
        }
        let mut trials = 0;
        while let Some((code, length)) = self.stack.pop() {
            if length > best.1 {
                best = (code, length);
            } else if trials < TRIALS {
                trials += 1;
            } else {
                break;
            }
            let Some(wish) = ahead.get(length) else {
                break;
            };
            let choices = &tolerance.ordered[usize::from(wish.row)];
            if usize::from(self.children[usize::from(code)]) <= choices.len() {
                let mut longer = self.child[usize::from(code)];
                while longer != NONE {
                    if wish.takes(tolerance, self.symbol[usize::from(longer)]) {
                        self.stack.push((longer, length + 1));
                    }
                    longer = self.sibling[usize::from(longer)];
                }
            } else {
                let kept = wish.keep.then_some(TRANSPARENT);
                for &symbol in choices.iter().chain(&kept) {
                    if let Some(longer) = self.longer(code, symbol) {
                        self.stack.push((longer, length + 1));
                    }
                }
            }
        }
        best
    }

    /// Finds a string with one more symbol, if it is known.
    #[inline(always)]
    fn longer(&self, code: u16, symbol: u8) -> Option<u16> {
        find(&self.slots, u32::from(code), symbol).ok().map(|code| code as u16)
    }

    /// Whether the previous string followed by its first symbol fits the pixels ahead, and is longer than `length`.
    fn repeats(&self, ahead: &[Wish], tolerance: &Tolerance, length: usize) -> bool {
        let symbols = self.string.iter().chain(self.string.first());
        self.string.len() >= length
            && self.string.len() < ahead.len()
            && symbols.zip(ahead).all(|(&symbol, wish)| wish.takes(tolerance, symbol))
    }

    /// Writes the symbols of a string to the buffer.
    fn spell(&mut self, code: u16, length: usize) {
        self.string.resize(length, 0);
        let mut code = usize::from(code);
        for symbol in self.string.iter_mut().rev() {
            *symbol = self.symbol[code];
            code = usize::from(self.parent[code]);
        }
    }

    /// Adds a string: a known string and a symbol.
    fn learn(&mut self, code: u16, parent: u16, symbol: u8) {
        let (index, above) = (usize::from(code), usize::from(parent));
        (self.symbol[index], self.parent[index], self.sibling[index]) = (symbol, parent, self.child[above]);
        (self.child[index], self.child[above]) = (NONE, code);
        self.children[above] += 1;
        if let Err(slot) = find(&self.slots, u32::from(parent), symbol) {
            self.slots[slot] = key(u32::from(parent), symbol) << 12 | u32::from(code);
        }
    }
}
