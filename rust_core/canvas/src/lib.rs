//! Frames and films: rasterizes anti-aliased discs, lines, polygons and text, and encodes pixels as a GIF. The crate contains no
//! physics.
//!
//! Shapes are drawn on a [`Canvas`]. A [`Histogram`] counts the colors of a few canvases for a [`Palette`]. A [`Gif`] takes
//! canvases; [`Background`] encodes them on a separate thread, while the next frame is drawn:
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
//! # Ok::<(), physcore_canvas::CanvasError>(())
//! ```
//!
//! Modules, in the order of the data flow:
//!
//! - `view` projects points to pixels and maps values to inks;
//! - `shapes` defines the coverage of a pixel;
//! - `band` rasterizes on some rows of the `canvas`;
//! - `ink` blends colors;
//! - `painting` sorts shapes by depth;
//! - `eye` records the depth of pixels;
//! - `light` computes shadows (`shadow`) and ambient occlusion from these depths;
//! - `ground` draws the background in space;
//! - `texture` covers surfaces;
//! - `weave` draws threads on them;
//! - `sky` is what water reflects;
//! - `liquid` reconstructs liquid surfaces by `smoothing`;
//! - `heatmap` colors the values of grids;
//! - `density` exposes very many points;
//! - `oklab` is the space in which colors are compared;
//! - `visibility` weights errors by the texture around them;
//! - `histogram` counts colors;
//! - `palette` reduces them to 255 by `quantize`;
//! - `nearest` finds the nearest palette color for each pixel;
//! - `difference` leaves out unchanged pixels;
//! - `targets` gives the colors wanted at the others;
//! - `lossy` chooses palette colors by rate and distortion;
//! - `lzw` packs codes;
//! - `gif` writes the container;
//! - `background` moves encoding to another thread;
//! - `file` makes the file appear only when complete.

mod background;
mod band;
mod canvas;
mod color;
mod density;
mod difference;
mod error;
mod eye;
mod file;
mod gif;
mod ground;
mod heatmap;
mod histogram;
mod ink;
mod light;
mod liquid;
mod lossy;
mod lzw;
mod math;
mod nearest;
mod oklab;
mod painting;
mod palette;
mod quantize;
mod shadow;
mod shapes;
mod sky;
mod smoothing;
mod targets;
mod text;
mod texture;
mod trails;
mod view;
mod visibility;
mod weave;

pub use background::Background;
pub use canvas::Canvas;
pub use color::{Ink, Rgb};
pub use density::Exposure;
pub use error::CanvasError;
pub use eye::Eye;
pub use file::NewFile;
pub use gif::Gif;
pub use ground::Ground;
pub use heatmap::{Samples, Shading, coverage, heatmap};
pub use histogram::Histogram;
pub use ink::Mixing;
pub use light::Light;
pub use liquid::Drop;
pub use painting::{Lens, Painting};
pub use palette::Palette;
pub use shapes::{Disc, Halo, Line, Triangle};
pub use sky::Sky;
pub use text::{Align, missing_signs, set_fallback_font, text_width};
pub use texture::Texture;
pub use trails::Trails;
pub use view::{Fog, Projection, look_up, opaque};
