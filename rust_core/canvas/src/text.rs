//! Text: anti-aliased outlines of Noto Sans, of its fonts with mathematical and other symbols, and of Droid Sans Fallback. The
//! latter has Chinese, Japanese and Korean, and is read from a file by the first text that needs it. The fonts are made by
//! `scripts/subset-fonts`. Characters are placed one after the other, without ligatures.

#![expect(clippy::cast_possible_wrap, reason = "no label is longer than a picture is wide by far")]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, OnceLock};

use ab_glyph::{Font, FontRef, Glyph, GlyphId, PxScale, point};

use crate::canvas::Canvas;
use crate::color::Ink;
use crate::error::CanvasError;

/// Fonts. The first font that has a character draws it.
static FACES: LazyLock<Vec<FontRef<'static>>> = LazyLock::new(|| {
    let files: [&'static [u8]; 4] = [
        include_bytes!("../fonts/noto-sans.ttf"),
        include_bytes!("../fonts/noto-sans-math.ttf"),
        include_bytes!("../fonts/noto-sans-symbols.ttf"),
        include_bytes!("../fonts/noto-sans-symbols-2.ttf"),
    ];
    files.into_iter().filter_map(|bytes| FontRef::try_from_slice(bytes).ok()).collect()
});

/// Path of the font for characters that no font of `FACES` has.
static FALLBACK_PATH: OnceLock<PathBuf> = OnceLock::new();

/// Font for characters that no font of `FACES` has, or why it cannot be read.
static FALLBACK: LazyLock<Result<FontRef<'static>, String>> =
    LazyLock::new(|| read(FALLBACK_PATH.get().ok_or("no font for Chinese, Japanese and Korean is set")?));

/// Reads a font, which stays in memory.
fn read(path: &Path) -> Result<FontRef<'static>, String> {
    let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let face = FontRef::try_from_slice(bytes.leak()).ok();
    // Outlines come last in the file: they are missing where its end is.
    let whole = face.filter(|face| face.outline(face.glyph_id('\u{4E00}')).is_some());
    whole.ok_or_else(|| format!("{}: the file is damaged", path.display()))
}

/// Replacement of a character that no font has: U+FFFD, a question mark in a black diamond.
const MISSING: char = '\u{FFFD}';

/// Ratio of the em to the height of a line: an ascent of 1.07 em and a descent of 0.29 em leave no gap.
const EM: f32 = 1.0 / 1.362;
/// Ratio of the baseline to the height of a line, from its upper edge.
const BASELINE: f32 = 1.069 * EM;

/// Ratio of the drawn coverage of pixels to that of the outline: stems of small text are about a pixel wide, and lie between two
/// pixels.
const STRENGTH: f32 = 1.3;

/// Alignment of a label at the given x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Left end at x.
    Left,
    /// Middle at x.
    Center,
    /// Right end at x.
    Right,
}

/// Width of a label whose line is `height` pixels high [pixels].
pub fn text_width(text: &str, height: usize) -> usize {
    advances(text, height).sum::<f32>().ceil() as usize
}

/// Sets the file of the font for Chinese, Japanese and Korean. Has no effect after the first call.
pub fn set_fallback_font(path: PathBuf) {
    FALLBACK_PATH.get_or_init(|| path);
}

/// Characters of a text that no font has, each once; an error if the font that may have them cannot be read. Without it they
/// are drawn as U+FFFD.
pub fn missing_signs(text: &str) -> Result<String, CanvasError> {
    let mut missing = String::new();
    for sign in text.chars() {
        if !is_empty(sign) && find(sign).is_none() && !missing.contains(sign) {
            missing.push(sign);
        }
    }
    if !missing.is_empty()
        && let Err(cause) = &*FALLBACK
    {
        return Err(CanvasError::Font(cause.clone()));
    }
    Ok(missing)
}

impl Canvas {
    /// Writes one line of text, `height` pixels high, with its upper edge at `y`. A character that no font has becomes U+FFFD.
    pub fn text(&mut self, text: &str, [x, y]: [i32; 2], height: usize, color: Ink, align: Align) {
        let samples = self.samples();
        let (x, y, height) = (samples as i32 * x, samples as i32 * y, samples * height);
        let width = text_width(text, height) as i32;
        let left = match align {
            Align::Left => x,
            Align::Center => x - width / 2,
            Align::Right => x - width,
        };
        let baseline = (BASELINE * height as f32).round();
        let mut pen = 0.0;
        for (sign, advance) in text.chars().zip(advances(text, height)) {
            if let Some((face, id)) = glyph_of(sign) {
                let outlined = face.outline_glyph(Glyph { id, scale: scale(face, height), position: point(pen, baseline) });
                if let Some(outline) = outlined {
                    let corner = outline.px_bounds().min;
                    let (left, top) = (left + corner.x as i32, y + corner.y as i32);
                    outline.draw(|column, row, coverage| {
                        self.dot(left + column as i32, top + row as i32, color, (STRENGTH * coverage).min(1.0));
                    });
                }
            }
            pen += advance;
        }
    }
}

/// Advance width of each character [pixels].
fn advances(text: &str, height: usize) -> impl Iterator<Item = f32> {
    text.chars().map(move |sign| {
        glyph_of(sign).map_or(0.0, |(face, id)| {
            let units = face.units_per_em().unwrap_or(1000.0);
            face.h_advance_unscaled(id) * EM * height as f32 / units
        })
    })
}

/// Scale of a font that makes its em equal to that of the others.
fn scale(face: &FontRef<'_>, height: usize) -> PxScale {
    let units = face.units_per_em().unwrap_or(1000.0);
    PxScale::from(EM * height as f32 * face.height_unscaled() / units)
}

/// Font and glyph of a character; None for control characters.
fn glyph_of(sign: char) -> Option<(&'static FontRef<'static>, GlyphId)> {
    if is_empty(sign) { None } else { find(sign).or_else(|| find(MISSING)) }
}

/// First font that has a character, with the glyph.
fn find(sign: char) -> Option<(&'static FontRef<'static>, GlyphId)> {
    let glyph = |face: &'static FontRef<'static>| Some((face, face.glyph_id(sign))).filter(|(_, id)| id.0 != 0);
    FACES.iter().find_map(glyph).or_else(|| FALLBACK.as_ref().ok().and_then(glyph))
}

/// Whether a character has no width: a control character, or a selector of variants of the previous character.
fn is_empty(sign: char) -> bool {
    sign.is_control() || matches!(sign, '\u{200B}'..='\u{200F}' | '\u{2060}'..='\u{2064}' | '\u{FE00}'..='\u{FE0F}' | '\u{FEFF}')
}

#[cfg(test)]
mod tests {
    use super::{fs, read};
    use std::path::Path;

    #[test]
    fn a_font_that_is_missing_or_damaged_is_named() {
        let whole = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../python/physcore/film/fonts/droid-sans-fallback.ttf");
        let bytes = fs::read(&whole).expect("the font");
        let path = std::env::temp_dir().join(format!("physcore-font-{}.ttf", std::process::id()));
        assert!(read(&path).is_err_and(|cause| cause.contains("physcore-font-")));
        for length in [0, 100, bytes.len() / 2, bytes.len() * 9 / 10] {
            fs::write(&path, &bytes[..length]).expect("a disk");
            assert!(read(&path).is_err_and(|cause| cause.ends_with("the file is damaged")), "{length} bytes");
        }
        fs::remove_file(&path).expect("a file");
        assert!(read(&whole).is_ok());
    }
}
