//! LZW compression by rate and distortion. Each pixel may have any color near its own. The string is used that saves the most
//! codes for the error that it makes.
//!
//! The idea is that of `gifsicle --lossy` (K. Lesiński, 2014). Here the error of each pixel is bounded by itself: errors neither
//! add up nor spread.

use crate::lzw::{Codes, GREATEST_CODE, Slots, TRANSPARENT, find, free_slots, key};
use crate::oklab::{Lab, squared};
use crate::palette::{NEAR, Palette};

/// Number of strings tried at each position without finding a better one.
const TRIALS: usize = 10;
/// Gain by which a string that is tried may be behind the best one [codes].
const SLACK: f32 = 0.8;
/// Codes that a pixel costs on average where pictures change; the price at which a longer string is bought with an error.
const CODES_PER_PIXEL: f32 = 0.8;

/// Color wanted at a pixel, and the costs of others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub(crate) lab: Lab,
    /// Cost of a squared difference beyond that of the nearest color [codes].
    pub(crate) price: f32,
    /// Squared difference of the nearest palette color.
    pub(crate) least: f32,
    /// Cost of the color on the screen; infinite if it must not stay.
    pub(crate) keep: f32,
    /// Largest cost allowed; negative if only the color on the screen is.
    pub(crate) most: f32,
    /// Number of the nearest palette color.
    pub(crate) nearest: u8,
}

impl Target {
    /// Target of a pixel that stays as it is on the screen.
    pub(crate) const REST: Self = Self { lab: [0.0; 3], price: 0.0, least: 0.0, keep: 0.0, most: -1.0, nearest: 1 };

    /// Cost of a symbol [codes]; infinite if it is not allowed.
    #[inline(always)]
    fn cost(&self, colors: &[Lab; 256], symbol: u8) -> f32 {
        if symbol == TRANSPARENT {
            return self.keep;
        }
        let cost = self.price * (squared(self.lab, colors[usize::from(symbol)]) - self.least);
        if cost <= self.most { cost } else { f32::INFINITY }
    }
}

const NONE: u16 = u16::MAX;
const CODES: usize = GREATEST_CODE as usize + 1;

/// Encoder of targets; its memory is reused from frame to frame.
pub(crate) struct LossyEncoder {
    /// Tree of strings, by code.
    tree: Vec<StringNode>,
    /// Longer strings by string and symbol.
    slots: Box<Slots>,
    stack: Vec<Candidate>,
    string: Vec<u8>,
    bytes: Vec<u8>,
    /// Coordinates of the palette's colors, by number.
    colors: Box<[Lab; 256]>,
}

/// String with its last symbol, its prefix, a string that is longer by a symbol (child), and a string with the same prefix
/// (sibling).
#[derive(Clone, Copy, Debug)]
struct StringNode {
    symbol: u8,
    /// Number of children, up to 255.
    children: u8,
    parent: u16,
    child: u16,
    sibling: u16,
}

impl StringNode {
    const NEW: Self = Self { symbol: 0, children: 0, parent: NONE, child: NONE, sibling: NONE };
}

/// String that fits the pixels ahead.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    code: u16,
    length: usize,
    /// Codes saved, less the costs of the pixels.
    gain: f32,
}

impl LossyEncoder {
    pub(crate) fn new() -> Self {
        let tree = vec![StringNode::NEW; CODES];
        let (stack, string, bytes) = (Vec::new(), Vec::new(), Vec::new());
        Self { tree, slots: free_slots(), stack, string, bytes, colors: Box::new([[0.0; 3]; 256]) }
    }

    /// Appends the code size and the sub-blocks for symbols that suit `targets` to `out`, and writes the symbols to `symbols`.
    /// All symbols are below 2^`bits`.
    pub(crate) fn encode(&mut self, targets: &[Target], palette: &Palette, bits: u32, symbols: &mut Vec<u8>, out: &mut Vec<u8>) {
        (1..=palette.colors().len()).for_each(|number| self.colors[number] = palette.lab(number as u8));
        let bits = bits.max(2);
        let (clear, end) = (1 << bits, (1 << bits) + 1);
        let mut bytes = std::mem::take(&mut self.bytes);
        let mut codes = Codes::new(&mut bytes, bits);
        let mut next = end + 1;
        let mut before: Option<u16> = None;
        self.forget();
        codes.write(clear);
        symbols.clear();
        while symbols.len() < targets.len() {
            let ahead = &targets[symbols.len()..];
            let best = self.best(ahead, palette);
            // The string that the decoder learns from this very code: the previous string and its first symbol.
            let code = if before.is_some() && self.repetition(ahead) > best.gain {
                self.string.push(self.string[0]);
                next as u16
            } else {
                self.spell(best.code, best.length);
                best.code
            };
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
        // Shorter codes of a smaller palette have overwritten single symbols of a larger one.
        for (code, node) in self.tree.iter_mut().enumerate() {
            *node = StringNode { symbol: code as u8, ..StringNode::NEW };
        }
        self.slots.fill(0);
    }

    /// Finds the string of the largest gain among those tried.
    fn best(&mut self, ahead: &[Target], palette: &Palette) -> Candidate {
        let first = &ahead[0];
        self.stack.clear();
        if first.most >= 0.0 {
            for &root in palette.near(first.nearest).iter().rev() {
                let cost = first.cost(&self.colors, root);
                if cost < f32::INFINITY {
                    self.stack.push(Candidate { code: u16::from(root), length: 1, gain: CODES_PER_PIXEL - cost });
                }
            }
        }
        if first.keep < f32::INFINITY {
            self.stack.push(Candidate { code: u16::from(TRANSPARENT), length: 1, gain: CODES_PER_PIXEL - first.keep });
        }
        let mut best = self.stack[self.stack.len() - 1];
        let mut trials = 0;
        while let Some(candidate) = self.stack.pop() {
            if candidate.gain > best.gain {
                best = candidate;
            } else if candidate.gain + SLACK < best.gain {
                continue;
            } else if trials < TRIALS {
                trials += 1;
            } else {
                break;
            }
            let Some(target) = ahead.get(candidate.length) else {
                break;
            };
            self.extend(candidate, target, palette);
        }
        best
    }

    /// Puts the strings on the stack that are longer by one symbol that suits a target.
    #[inline(always)]
    fn extend(&mut self, candidate: Candidate, target: &Target, palette: &Palette) {
        let node = self.tree[usize::from(candidate.code)];
        let (length, gain) = (candidate.length + 1, candidate.gain + CODES_PER_PIXEL);
        if target.most >= 0.0 && usize::from(node.children) <= NEAR {
            let mut code = node.child;
            while code != NONE {
                let longer = self.tree[usize::from(code)];
                let gain = gain - target.cost(&self.colors, longer.symbol);
                if gain > f32::NEG_INFINITY {
                    self.stack.push(Candidate { code, length, gain });
                }
                code = longer.sibling;
            }
            return;
        }
        if target.most >= 0.0 {
            for &symbol in palette.near(target.nearest).iter().rev() {
                let gain = gain - target.cost(&self.colors, symbol);
                if gain > f32::NEG_INFINITY
                    && let Some(code) = self.longer(candidate.code, symbol)
                {
                    self.stack.push(Candidate { code, length, gain });
                }
            }
        }
        if target.keep < f32::INFINITY
            && let Some(code) = self.longer(candidate.code, TRANSPARENT)
        {
            self.stack.push(Candidate { code, length, gain: gain - target.keep });
        }
    }

    /// Finds a string with one more symbol, if it is known.
    #[inline(always)]
    fn longer(&self, code: u16, symbol: u8) -> Option<u16> {
        find(&self.slots, u32::from(code), symbol).ok().map(|code| code as u16)
    }

    /// Gain of the previous string followed by its first symbol; negative if it does not fit the pixels ahead.
    fn repetition(&self, ahead: &[Target]) -> f32 {
        let length = self.string.len() + 1;
        if length > ahead.len() {
            return -1.0;
        }
        let symbols = self.string.iter().chain(self.string.first());
        let mut cost = 0.0;
        for (&symbol, target) in symbols.zip(ahead) {
            cost += target.cost(&self.colors, symbol);
            if cost == f32::INFINITY {
                return -1.0;
            }
        }
        CODES_PER_PIXEL * length as f32 - cost
    }

    /// Writes the symbols of a string to the buffer.
    fn spell(&mut self, code: u16, length: usize) {
        self.string.resize(length, 0);
        let mut code = usize::from(code);
        for symbol in self.string.iter_mut().rev() {
            *symbol = self.tree[code].symbol;
            code = usize::from(self.tree[code].parent);
        }
    }

    /// Adds a string: a known string and a symbol.
    fn learn(&mut self, code: u16, parent: u16, symbol: u8) {
        let above = &mut self.tree[usize::from(parent)];
        let sibling = std::mem::replace(&mut above.child, code);
        above.children = above.children.saturating_add(1);
        self.tree[usize::from(code)] = StringNode { symbol, children: 0, parent, child: NONE, sibling };
        if let Err(slot) = find(&self.slots, u32::from(parent), symbol) {
            self.slots[slot] = key(u32::from(parent), symbol) << 12 | u32::from(code);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LossyEncoder, Target};
    use crate::histogram::Histogram;
    use crate::oklab::squared;
    use crate::palette::Palette;
    use crate::{Canvas, Rgb};

    /// Decodes symbols by the `weezl` crate, which shares no code with this crate.
    fn decoded(blocks: &[u8]) -> Vec<u8> {
        let mut codes = Vec::new();
        let mut rest = &blocks[1..];
        while rest[0] > 0 {
            let (block, next) = rest[1..].split_at(usize::from(rest[0]));
            codes.extend_from_slice(block);
            rest = next;
        }
        assert_eq!(rest, [0], "the last block is the empty one");
        let mut decoder = weezl::decode::Decoder::new(weezl::BitOrder::Lsb, blocks[0]);
        let symbols = decoder.decode(&codes).expect("an end that is marked");
        assert!(decoder.has_ended());
        symbols
    }

    /// Covers every length, so each code width also occurs just before the end. Noise fills the dictionary; runs do not. With a
    /// tolerance and without. No pixel costs more than allowed.
    #[test]
    fn another_decoder_reads_what_was_chosen_within_the_bounds() {
        let colors: Vec<Rgb> = (0..31_u8).map(|level| [8 * level, 100, 255 - 8 * level]).collect();
        let mut canvas = Canvas::new(31, 1, colors[0]).expect("a valid size");
        canvas.picture(&colors, 31, [0, 0]);
        let mut histogram = Histogram::default();
        histogram.observe(&canvas);
        let mut palette = Palette::new(&histogram, &[], 31);
        let noise = (0..9000_u32).map(|n| (n.wrapping_mul(n).wrapping_mul(0x9E37_79B1) >> 24) as u8).collect();
        let runs = (0..9000_u32).map(|n| 90 + 7 * (n.isqrt() % 3) as u8).collect();
        let mut encoder = LossyEncoder::new();
        for (levels, price, most) in [(&noise, 1.0, 0.0), (&noise, 0.02, 1.0), (&runs, 1.0, 0.0)] {
            let levels: &Vec<u8> = levels;
            let targets: Vec<Target> = levels
                .iter()
                .map(|&level| {
                    let found = palette.nearest([level, 100, 255 - level]);
                    let keep = if level % 5 == 0 { 0.5 * most } else { f32::INFINITY };
                    Target { lab: found.lab, price, least: found.least, keep, most, nearest: found.index + 1 }
                })
                .collect();
            for length in (1..1200).chain([4100, 9000]) {
                let (mut symbols, mut blocks) = (Vec::new(), Vec::new());
                encoder.encode(&targets[..length], &palette, 5, &mut symbols, &mut blocks);
                assert_eq!(decoded(&blocks), symbols);
                assert_eq!(symbols.len(), length);
                for (&symbol, target) in symbols.iter().zip(&targets) {
                    let excess = match symbol {
                        0 => target.keep,
                        _ => price * (squared(palette.lab(symbol), target.lab) - target.least),
                    };
                    assert!(excess <= most, "{excess} of {most}");
                }
            }
        }
    }

    /// Codes of a small palette's strings are single symbols of a larger one.
    #[test]
    fn a_larger_palette_may_follow_a_smaller_one() {
        let colors: Vec<Rgb> = (0..200_u8).map(|level| [level, 100, 255 - level]).collect();
        let mut canvas = Canvas::new(200, 1, colors[0]).expect("a valid size");
        canvas.picture(&colors, 200, [0, 0]);
        let mut histogram = Histogram::default();
        histogram.observe(&canvas);
        let mut encoder = LossyEncoder::new();
        for (most, bits) in [(15, 4), (255, 8)] {
            let mut palette = Palette::new(&histogram, &[], most);
            let target = |&color: &Rgb| {
                let found = palette.nearest(color);
                Target {
                    lab: found.lab,
                    price: 1.0,
                    least: found.least,
                    keep: f32::INFINITY,
                    most: 0.0,
                    nearest: found.index + 1,
                }
            };
            let targets: Vec<Target> = colors.iter().map(target).collect();
            let (mut symbols, mut blocks) = (Vec::new(), Vec::new());
            encoder.encode(&targets, &palette, bits, &mut symbols, &mut blocks);
            assert_eq!(decoded(&blocks), symbols);
            assert!(symbols.iter().zip(&targets).all(|(&symbol, target)| symbol == target.nearest));
        }
    }
}
