//! LZW as GIF uses it (Welch 1984; GIF89a, appendix F), with one freedom more.
//!
//! A pixel that has not changed since the last frame may be written as its color or as "transparent". The encoder takes whichever
//! continues the string that it is matching, so one pass gets the long runs of transparency where the picture rests *and* the
//! repetitions of the picture where it moves. Measured on the frames of `benches/frames.rs` that gives smaller files than
//! either choice for whole frames, in less time than one pass of the usual tree of nodes.

/// The index that stands for "as it was" in a frame; no color has it.
pub(crate) const TRANSPARENT: u8 = 0;

const GREATEST_CODE: u32 = 4095;
const SLOTS: usize = 1 << 14;

/// The encoder's dictionary, kept from frame to frame for its memory alone.
pub(crate) struct Encoder {
    /// (string, next symbol) → longer string, in an open-addressed table: 12 + 8 bits of key above 12 bits of code, 0 is free.
    /// At most a quarter full, so a search looks at little more than one slot.
    slots: Box<[u32; SLOTS]>,
}

impl Encoder {
    pub(crate) fn new() -> Self {
        Self { slots: Box::new([0; SLOTS]) }
    }

    /// Appends to `out` the code size and the sub-blocks for `pixels`, all of them indices below 2^`bits`.
    ///
    /// `before` are the same pixels of the last frame, if it shall be built upon. Returns whether transparency was used.
    pub(crate) fn encode(&mut self, pixels: &[u8], before: Option<&[u8]>, bits: u32, out: &mut Vec<u8>) -> bool {
        let bits = bits.max(2);
        let clear = 1 << bits;
        let mut codes = Codes::new(out, bits);
        self.slots.fill(0);
        codes.write(clear);
        let mut next = clear + 2;
        let Some((&first, rest)) = pixels.split_first() else {
            codes.finish(clear + 1);
            return false;
        };
        let rests = |index: usize| before.is_some_and(|before| before[index] == pixels[index]);
        let mut transparent = rests(0);
        let mut string = u32::from(if transparent { TRANSPARENT } else { first });
        for (color, index) in rest.iter().copied().zip(1..) {
            let unchanged = rests(index);
            let wanted = if unchanged { TRANSPARENT } else { color };
            let slot = match self.find(string, wanted) {
                Ok(longer) => {
                    transparent |= unchanged;
                    string = longer;
                    continue;
                }
                Err(slot) => slot,
            };
            if unchanged && let Ok(longer) = self.find(string, color) {
                string = longer;
                continue;
            }
            transparent |= unchanged;
            codes.write(string);
            if next > GREATEST_CODE {
                codes.write(clear);
                self.slots.fill(0);
                next = clear + 2;
            } else {
                self.slots[slot] = key(string, wanted) << 12 | next;
                codes.widen(next);
                next += 1;
            }
            string = u32::from(wanted);
        }
        codes.write(string);
        codes.widen(next);
        codes.finish(clear + 1);
        transparent
    }

    /// The code of a string with one more symbol, or else the free slot where it belongs.
    #[inline(always)]
    fn find(&self, string: u32, symbol: u8) -> Result<u32, usize> {
        let key = key(string, symbol);
        // Fibonacci hashing: the multiplier is 2³² over the golden ratio.
        let mut slot = (key.wrapping_mul(0x9E37_79B1) >> (32 - SLOTS.ilog2())) as usize;
        loop {
            let entry = self.slots[slot];
            if entry == 0 {
                return Err(slot);
            }
            if entry >> 12 == key {
                return Ok(entry & 0xFFF);
            }
            slot = (slot + 1) % SLOTS;
        }
    }
}

#[inline(always)]
fn key(string: u32, symbol: u8) -> u32 {
    string << 8 | u32::from(symbol)
}

/// Codes of growing width, packed from the least significant bit into blocks of up to 255 bytes.
struct Codes<'a> {
    out: &'a mut Vec<u8>,
    block: usize,
    pending: u64,
    count: u32,
    width: u32,
    bits: u32,
}

impl<'a> Codes<'a> {
    fn new(out: &'a mut Vec<u8>, bits: u32) -> Self {
        out.push(bits as u8);
        let block = out.len();
        out.push(0);
        Self { out, block, pending: 0, count: 0, width: bits + 1, bits }
    }

    #[inline(always)]
    fn write(&mut self, code: u32) {
        self.pending |= u64::from(code) << self.count;
        self.count += self.width;
        while self.count >= 8 {
            self.push();
        }
        if code == 1 << self.bits {
            self.width = self.bits + 1;
        }
    }

    /// The decoder knows a string one code later than the encoder, so codes grow when `newest` is the first that needs it.
    #[inline(always)]
    fn widen(&mut self, newest: u32) {
        if newest == 1 << self.width && self.width < 12 {
            self.width += 1;
        }
    }

    #[inline(always)]
    fn push(&mut self) {
        if self.out.len() - self.block == 256 {
            self.out[self.block] = 255;
            self.block = self.out.len();
            self.out.push(0);
        }
        self.out.push(self.pending as u8);
        self.pending >>= 8;
        self.count = self.count.saturating_sub(8);
    }

    fn finish(mut self, end: u32) {
        self.write(end);
        if self.count > 0 {
            self.push();
        }
        let length = self.out.len() - self.block - 1;
        self.out[self.block] = length as u8;
        if length > 0 {
            self.out.push(0);
        }
    }
}
