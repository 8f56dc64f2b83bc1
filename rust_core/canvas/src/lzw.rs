//! LZW compression as used by GIF (Welch 1984; `GIF89a`, appendix F).

/// Transparent index: the pixel keeps its previous color.
pub(crate) const TRANSPARENT: u8 = 0;

pub(crate) const GREATEST_CODE: u32 = 4095;
const SLOTS: usize = 1 << 14;
/// Open-addressed hash table from (string, next symbol) to the longer string: 12 + 8 bits of key above 12 bits of code; 0 is
/// free. The table is at most a quarter full, so a search takes little more than one probe.
pub(crate) type Slots = [u32; SLOTS];

/// Returns an empty table.
#[expect(clippy::large_stack_arrays, reason = "64 KiB once per film, on the way to the heap")]
pub(crate) fn free_slots() -> Box<Slots> {
    Box::new([0; SLOTS])
}

/// Finds the code of a string with one more symbol, or the free slot for it.
#[inline(always)]
pub(crate) fn find(slots: &Slots, string: u32, symbol: u8) -> Result<u32, usize> {
    let key = key(string, symbol);
    // Symbols are spread by the golden ratio. The string, for which each step must wait, needs only one more operation.
    let spread = u32::from(symbol).wrapping_mul(0x9E37_79B1) >> (32 - SLOTS.ilog2());
    let mut slot = (spread ^ string) as usize % SLOTS;
    loop {
        let entry = slots[slot];
        if entry >> 12 == key {
            return Ok(entry & 0xFFF);
        }
        if entry == 0 {
            return Err(slot);
        }
        slot = (slot + 1) % SLOTS;
    }
}

/// Key of a string and a symbol: both numbers side by side, plus one, so no key is 0.
#[inline(always)]
pub(crate) fn key(string: u32, symbol: u8) -> u32 {
    (string << 8 | u32::from(symbol)) + 1
}

/// Codes of growing width, packed from the least significant bit.
pub(crate) struct Codes<'a> {
    bytes: &'a mut Vec<u8>,
    pending: u64,
    count: u32,
    width: u32,
    bits: u32,
}

impl<'a> Codes<'a> {
    pub(crate) fn new(bytes: &'a mut Vec<u8>, bits: u32) -> Self {
        bytes.clear();
        Self { bytes, pending: 0, count: 0, width: bits + 1, bits }
    }

    #[inline(always)]
    pub(crate) fn write(&mut self, code: u32) {
        self.pending |= u64::from(code) << self.count;
        self.count += self.width;
        if self.count >= 32 {
            self.bytes.extend_from_slice(&(self.pending as u32).to_le_bytes());
            self.pending >>= 32;
            self.count -= 32;
        }
        if code == 1 << self.bits {
            self.width = self.bits + 1;
        }
    }

    /// Widens the codes. The decoder adds a string one code later than the encoder, so codes grow when `newest` is the first that
    /// needs it.
    #[inline(always)]
    pub(crate) fn widen(&mut self, newest: u32) {
        if newest == 1 << self.width && self.width < 12 {
            self.width += 1;
        }
    }

    /// Writes the last code, and appends everything in blocks of up to 255 bytes with their lengths, followed by an empty block.
    pub(crate) fn finish(mut self, end: u32, out: &mut Vec<u8>) {
        self.write(end);
        self.bytes.extend_from_slice(&self.pending.to_le_bytes()[..self.count.div_ceil(8) as usize]);
        out.push(self.bits as u8);
        for block in self.bytes.chunks(255) {
            out.push(block.len() as u8);
            out.extend_from_slice(block);
        }
        out.push(0);
    }
}
