//! Frames and films: anti-aliased discs, lines, polygons and text into pixels, and pixels into a GIF. It knows no physics.
//!
//! A [`Canvas`] is drawn on; a [`Histogram`] watches a few canvases and gives a [`Palette`]; a [`Gif`] takes canvases, and
//! [`Background`] lets it do so on a thread of its own, while the next frame is drawn:
//!
//! ```
//! use physcore_canvas::{Canvas, Disc, Gif, Histogram, Palette};
//!
//! let mut canvas = Canvas::new(64, 48, [16, 19, 24])?;
//! canvas.disc(Disc { center: [32.0, 24.0], radius: 5.0, color: [255, 160, 60, 255], shading: 0.0, softness: 1.0 });
//!
//! let mut histogram = Histogram::default();
//! histogram.observe(&canvas);
//! let mut gif = Gif::new(Vec::new(), &canvas, Palette::new(&histogram, &[[16, 19, 24]], 255))?;
//! gif.frame(&canvas, 3)?;
//! assert!(gif.finish()?.starts_with(b"GIF89a"));
//! # Ok::<(), physcore_canvas::Error>(())
//! ```
//!
//! The way of the data: `view` finds pixels and inks, `shapes` says how much of a pixel a shape covers, `band` finds those pixels on
//! some rows of the `canvas`, `ink` mixes colors into them, `painting` puts many shapes in order of depth, `texture` covers surfaces,
//! `liquid` lets drops flow together, `palette` reduces millions of colors to 255 by `quantize`, `nearest` finds the one of them for
//! each pixel, `difference` leaves out what has not changed, `lzw` packs the indices, `gif` writes the container, `background` moves
//! all this to another thread, and `file` makes sure that a file is either the whole new film or what it was before. [`Quality`] says
//! how fine the histogram and the look-up are, and whether a frame may be stored in two ways of which the smaller is kept.

mod background;
mod band;
mod canvas;
mod color;
mod difference;
mod error;
mod file;
mod gif;
mod ink;
mod liquid;
mod lzw;
mod nearest;
mod painting;
mod palette;
mod quality;
mod quantize;
mod shapes;
mod text;
mod texture;
mod trails;
mod view;

pub use background::Background;
pub use canvas::Canvas;
pub use color::{Ink, Rgb};
pub use error::Error;
pub use file::NewFile;
pub use gif::Gif;
pub use liquid::Drop;
pub use painting::{Lens, Painting};
pub use palette::{Histogram, Palette};
pub use quality::Quality;
pub use shapes::{Disc, Halo, Line, Triangle};
pub use text::{Align, text_width};
pub use texture::Texture;
pub use trails::Trails;
pub use view::{Fog, Projection, look_up, opaque};
