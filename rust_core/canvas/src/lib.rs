//! Frames and films: anti-aliased discs, lines, polygons and text into pixels, and pixels into a GIF. It knows no physics.
//!
//! A [`Canvas`] is drawn on; a [`Histogram`] watches a few canvases and gives a [`Palette`]; a [`Gif`] takes canvases:
//!
//! ```
//! use physcore_canvas::{Canvas, Disc, Gif, Histogram, Palette};
//!
//! let mut canvas = Canvas::new(64, 48, [16, 19, 24])?;
//! canvas.disc(Disc { center: [32.0, 24.0], radius: 5.0, color: [255, 160, 60, 255], shading: 0.0, softness: 1.0 });
//!
//! let mut histogram = Histogram::default();
//! histogram.observe(&canvas);
//! let mut gif = Gif::new(Vec::new(), &canvas, Palette::new(&histogram, &[[16, 19, 24]]))?;
//! gif.frame(&canvas, 3)?;
//! assert!(gif.finish()?.starts_with(b"GIF89a"));
//! # Ok::<(), physcore_canvas::Error>(())
//! ```
//!
//! The way of the data: `view` finds pixels and inks, `shapes` says how much of a pixel a shape covers, `band` finds those pixels on
//! some rows of the `canvas`, `ink` mixes colors into them, `painting` puts many
//! shapes in order of depth, `texture` covers surfaces, `liquid` lets drops flow together, `palette` reduces millions of colors to 255, `lzw` packs the indices, `gif` writes the container,
//! and `file` makes sure that a file is either the whole new film or what it was before.

mod band;
mod canvas;
mod color;
mod error;
mod file;
mod gif;
mod ink;
mod liquid;
mod lzw;
mod painting;
mod palette;
mod shapes;
mod text;
mod texture;
mod trails;
mod view;

pub use canvas::Canvas;
pub use color::{Ink, Rgb};
pub use error::Error;
pub use file::NewFile;
pub use gif::Gif;
pub use liquid::Drop;
pub use painting::{Lens, Painting};
pub use palette::{Histogram, Palette};
pub use shapes::{Disc, Halo, Line, Triangle};
pub use text::{Align, text_width};
pub use texture::Texture;
pub use trails::Trails;
pub use view::{Fog, Projection, look_up, opaque};
