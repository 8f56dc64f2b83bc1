//! Tests of text: every drawn character is the intended one.

use physcore_canvas::{Align, Canvas, missing_signs, set_fallback_font, text_width};

const GROUND: [u8; 3] = [0, 0, 0];

fn written(text: &str, height: usize, align: Align) -> Vec<[u8; 4]> {
    set_fallback_font(concat!(env!("CARGO_MANIFEST_DIR"), "/../../python/physcore/film/fonts/droid-sans-fallback.ttf").into());
    let mut canvas = Canvas::new(200, 80, GROUND).expect("a valid size");
    canvas.text(text, [100, 20], height, [255; 4], align);
    canvas.pixels().to_vec()
}

/// Columns and rows from the first to the last with ink.
fn extent(pixels: &[[u8; 4]]) -> [usize; 4] {
    let inked = || pixels.iter().enumerate().filter(|(_, pixel)| pixel[0] > 0).map(|(index, _)| (index % 200, index / 200));
    let columns = || inked().map(|(column, _)| column);
    let rows = || inked().map(|(_, row)| row);
    [columns().min(), columns().max(), rows().min(), rows().max()].map(|edge| edge.expect("ink"))
}

#[test]
fn signs_of_many_scripts_have_glyphs_of_their_own() {
    let signs = "Aéßñ αβγωΩ Дж v₀x²ₙ ∇∂∑∫√≈≤±×÷·°→⇒⟨⟩ 抛体运动弹簧 振動 ひらカナ 한글 ✓☉♁ ℏ 𝑣";
    let mut seen: Vec<(char, Vec<[u8; 4]>)> = Vec::new();
    for sign in signs.chars().filter(|sign| !sign.is_whitespace()) {
        let picture = written(&sign.to_string(), 32, Align::Left);
        assert!(picture.iter().any(|pixel| pixel[0] > 100), "{sign} has ink");
        for (other, drawn) in &seen {
            // Some letters look alike in Latin and Cyrillic; none of these do.
            assert!(*other == sign || *drawn != picture, "{sign} differs from {other}");
        }
        seen.push((sign, picture));
    }
    assert_eq!(missing_signs(signs).expect("the font"), "");
}

#[test]
fn missing_signs_are_named_once_and_drawn_as_the_replacement_character() {
    assert_eq!(written("😀", 24, Align::Left), written("\u{FFFD}", 24, Align::Left));
    assert_eq!(missing_signs("a😀b😀\u{1F308}\n\u{FE0F}").expect("the font"), "😀\u{1F308}");
    assert_ne!(written("😀", 24, Align::Left), written("?", 24, Align::Left));
}

#[test]
fn a_line_stays_in_its_height_and_is_as_wide_as_said() {
    for height in [9, 16, 21, 40] {
        for text in ["Ågjpq|(ÄÖÜ", "运动 v₀", "0123456789"] {
            let [left, right, top, bottom] = extent(&written(text, height, Align::Left));
            assert!(left + 1 >= 100 && right <= 100 + text_width(text, height) + 1, "{text} at {height}: {left}–{right}");
            assert!(top >= 20 && bottom < 20 + height + height / 8, "{text} at {height}: {top}–{bottom}");
        }
    }
}

/// Digits have equal widths, so a clock does not tremble.
#[test]
fn digits_are_equally_wide() {
    assert!(('0'..='9').all(|digit| text_width(&digit.to_string().repeat(10), 24) == text_width("0000000000", 24)));
}

#[test]
fn a_label_goes_left_right_or_around_its_place() {
    let width = text_width("aligned", 24);
    let [left, ..] = extent(&written("aligned", 24, Align::Left));
    let [middle, ..] = extent(&written("aligned", 24, Align::Center));
    let [right, ..] = extent(&written("aligned", 24, Align::Right));
    assert_eq!([left - middle, left - right], [width / 2, width]);
}
