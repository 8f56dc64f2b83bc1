//! Depth-sorted drawing of many shapes (painter's algorithm).

use std::sync::Arc;
use std::thread::available_parallelism;

use crate::band::Band;
use crate::canvas::Canvas;
use crate::eye::{Eye, is_solid};
use crate::ink::Mixing;
use crate::light::{Depths, Light, Lighting};
use crate::liquid::{Drop, Liquid};
use crate::shadow::{Caster, ShadowMap};
use crate::shapes::{Disc, Halo, Line, Triangle};
use crate::sky::Sky;
use crate::texture::Texture;

/// Queue of shapes for drawing. Shapes with greater depth are drawn first, shapes of equal depth in the order of addition. A
/// liquid hides shapes behind its front.
#[derive(Debug, Default)]
pub struct Painting {
    discs: Vec<Disc>,
    /// Lines, with the depths of their ends.
    lines: Vec<(Line, [f32; 2])>,
    /// Triangles with their textures and weaves.
    triangles: Vec<(Triangle, Option<u16>, Option<u32>)>,
    /// Coordinates of threads at the corners of woven triangles.
    weaves: Vec<[[f32; 2]; 3]>,
    halos: Vec<Halo>,
    textures: Vec<Arc<Texture>>,
    liquid: Liquid,
    order: Vec<Entry>,
    has_depth: bool,
    lens: Lens,
    light: Option<Light>,
    /// Number of samples along the side of a pixel of the present canvas.
    samples: f32,
}

/// Thin lens that blurs shapes in front of and behind the focus, at depth 0; no blur by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Circle of confusion per unit of distance from the focus, close to the focus [pixels].
    pub blur: f32,
    /// Distance of the eye from the focus, in the unit of depths.
    pub distance: f32,
}

impl Default for Lens {
    fn default() -> Self {
        Self { blur: 0.0, distance: f32::INFINITY }
    }
}

impl Lens {
    /// Circle of confusion of a point at a depth z [pixels], for a thin lens: c = b |z| / (1 + z / d).
    ///
    /// Source: M. Potmesil and I. Chakravarty, "A lens and aperture camera model for synthetic image generation" (1981).
    fn confusion(self, depth: f32) -> f32 {
        const NEAREST: f32 = 0.05;
        self.blur * depth.abs() / (1.0 + depth / self.distance).max(NEAREST)
    }
}

/// Number of shapes below which one thread is faster than several.
const FEW: usize = 1000;

#[derive(Clone, Copy, Debug)]
struct Entry {
    depth: f32,
    shape: Shape,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    Disc(u32),
    Line(u32, Mixing),
    Triangle(u32),
    Halo(u32),
}

impl Painting {
    /// Applies a lens to everything added later.
    pub fn look_through(&mut self, lens: Lens) {
        self.lens = lens;
    }

    /// Lights everything painted next, and its background, on a canvas that has an eye.
    pub fn light(&mut self, light: Light) {
        self.light = Some(light);
    }

    /// Adds a disc; `depth` is its distance behind the focus, in any unit.
    pub fn disc(&mut self, disc: Disc, depth: f32) {
        self.add(depth, Shape::Disc(self.discs.len() as u32));
        self.discs.push(if self.lens.blur > 0.0 { disc.blurred(self.lens.confusion(depth)) } else { disc });
    }

    /// Paints all queued shapes, then discs without depth. The discs are not stored, so a million of them take no memory.
    pub fn paint_discs(&mut self, canvas: &mut Canvas, discs: &(impl Iterator<Item = Disc> + Clone + Sync)) {
        self.paint(canvas);
        let times = canvas.samples() as f32;
        let draw =
            |band: &mut Band<'_>| discs.clone().for_each(|disc| band.disc(if times > 1.0 { disc.scaled(times) } else { disc }));
        in_bands(canvas, threads(discs.size_hint().0), &draw);
    }

    /// Adds a line; `depths` of its ends as for [`Painting::disc`].
    pub fn line(&mut self, line: Line, depths: [f32; 2]) {
        let depth = 0.5 * (depths[0] + depths[1]);
        self.add(depth, Shape::Line(self.lines.len() as u32, Mixing::Over));
        let seen = if self.lens.blur > 0.0 { line.blurred(self.lens.confusion(depth)) } else { line };
        self.lines.push((seen, depths));
    }

    /// Adds a line that only lightens, or only darkens, the background; `depth` as for [`Painting::disc`].
    pub fn trail(&mut self, line: Line, mixing: Mixing, depth: f32) {
        self.line(line, [depth; 2]);
        if let Some(Entry { shape, .. }) = self.order.last_mut() {
            *shape = Shape::Line(self.lines.len() as u32 - 1, mixing);
        }
    }

    /// Adds a triangle; `depth` as for [`Painting::disc`], `texture` as returned by [`Painting::texture`].
    pub fn triangle(&mut self, triangle: Triangle, texture: Option<u16>, depth: f32) {
        self.add(depth, Shape::Triangle(self.triangles.len() as u32));
        self.triangles.push((triangle, texture, None));
    }

    /// Adds a triangle of cloth, with coordinates across its two sets of threads at the corners [threads]; otherwise as
    /// [`Painting::triangle`].
    pub fn woven(&mut self, triangle: Triangle, texture: Option<u16>, threads: [[f32; 2]; 3], depth: f32) {
        self.triangle(triangle, texture, depth);
        if let Some((_, _, weave)) = self.triangles.last_mut() {
            *weave = Some(self.weaves.len() as u32);
            self.weaves.push(threads);
        }
    }

    /// Adds a halo; `depth` as for [`Painting::disc`].
    pub fn halo(&mut self, halo: Halo, depth: f32) {
        self.add(depth, Shape::Halo(self.halos.len() as u32));
        self.halos.push(halo);
    }

    /// Registers a texture for triangles, until the painting is painted.
    pub fn texture(&mut self, texture: Arc<Texture>) -> u16 {
        self.textures.push(texture);
        (self.textures.len() - 1) as u16
    }

    /// Begins a liquid, before any drop: pixels per unit of depth (0 in 2D), the reflected sky (3D), and the share of its color that
    /// the liquid emits.
    pub fn begin_liquid(&mut self, scale: f32, sky: Sky, glow: f32) {
        self.liquid.begin(scale, sky, glow);
    }

    /// Adds a particle of a liquid.
    pub fn drop(&mut self, drop: Drop) {
        self.liquid.drop(drop);
    }

    /// Number of queued shapes and drops.
    pub fn len(&self) -> usize {
        self.order.len() + self.liquid.len()
    }

    /// Whether no shape or drop is queued.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Paints all queued shapes and empties the queue; its memory is reused for the next frame.
    pub fn paint(&mut self, canvas: &mut Canvas) {
        self.samples = canvas.samples() as f32;
        if canvas.samples() > 1 {
            self.magnify(canvas.samples() as f32);
        }
        if self.has_depth {
            radsort::sort_by_key(&mut self.order, |entry| -entry.depth); // stable, and ten times faster for millions
        }
        if !self.liquid.is_empty() {
            self.liquid.settle(canvas.width(), canvas.height());
        }
        let threads = if self.liquid.is_empty() { threads(self.order.len()) } else { threads(FEW) };
        if self.liquid.is_empty() {
            in_bands(canvas, threads, &|band: &mut Band<'_>| self.order.iter().for_each(|entry| self.draw(entry, band)));
        } else {
            self.draw_with_liquid(canvas, threads);
        }
        if let (Some(light), Some(eye)) = (self.light.take(), canvas.eye()) {
            self.shade(canvas, light, eye);
        }
        self.liquid.clear();
        self.discs.clear();
        self.lines.clear();
        self.triangles.clear();
        self.weaves.clear();
        self.halos.clear();
        self.textures.clear();
        self.order.clear();
        self.has_depth = false;
    }

    /// Scales all queued shapes to a picture with `times` as many pixels along each side.
    fn magnify(&mut self, times: f32) {
        self.discs.iter_mut().for_each(|disc| *disc = disc.scaled(times));
        self.lines.iter_mut().for_each(|(line, _)| *line = line.scaled(times));
        self.triangles.iter_mut().for_each(|(triangle, ..)| *triangle = triangle.scaled(times));
        self.halos.iter_mut().for_each(|halo| *halo = halo.scaled(times));
        self.liquid.magnify(times);
        self.light = self.light.map(|light| Light { reach: times * light.reach, ..light });
    }

    /// Lights the painted shapes. Without shadow casters, nothing is lit.
    fn shade(&self, canvas: &mut Canvas, light: Light, eye: Eye) {
        let casters = self.casters(eye);
        if casters.is_empty() {
            return;
        }
        let depths = canvas.depths().to_vec();
        let backdrop = canvas.backdrop_depths().to_vec();
        let depths = Depths { eye, width: canvas.width(), values: &depths, backdrop: &backdrop };
        let shadows = ShadowMap::new(light.lamp, &casters);
        let lighting = Lighting::new(light, shadows, &depths, threads(FEW));
        in_bands(canvas, threads(FEW), &|band: &mut Band<'_>| lighting.shade(band, &depths));
    }

    /// Shadow casters, with the share of light that each blocks.
    fn casters(&self, eye: Eye) -> Vec<(Caster, f32)> {
        let mut casters = Vec::with_capacity(self.len());
        for Entry { depth, shape } in self.order.iter().filter(|entry| entry.depth.is_finite()) {
            let per_pixel = eye.length(*depth);
            let caster = match *shape {
                Shape::Disc(index) => {
                    let disc = &self.discs[index as usize];
                    let thrown = disc.shading > 0.0 && is_solid(disc.color);
                    thrown.then(|| Caster::Ball(eye.place(disc.center, *depth), disc.radius * per_pixel))
                }
                Shape::Line(index, Mixing::Over) => {
                    let (line, [near, far]) = &self.lines[index as usize];
                    let (from, to) = (eye.place(line.from, *near), eye.place(line.to, *far));
                    is_solid(line.color).then_some(Caster::Rod(from, to, 0.5 * line.width * per_pixel))
                }
                Shape::Triangle(index) => {
                    let Triangle { corners, depths, colors, lit, .. } = self.triangles[index as usize].0;
                    let place = |corner: usize| eye.place(corners[corner], depths[corner]);
                    (lit && is_solid(colors[0])).then(|| Caster::Triangle([place(0), place(1), place(2)]))
                }
                _ => None,
            };
            casters.extend(caster.filter(Caster::is_somewhere).map(|caster| (caster, 1.0)));
        }
        casters.extend(self.liquid.casters(eye));
        casters
    }

    /// Draws the shapes behind the liquid, then the transparent liquid, then the shapes in front.
    fn draw_with_liquid(&self, canvas: &mut Canvas, threads: usize) {
        let in_front = |entry: &&Entry| self.liquid.leaves_in_front(self.anchor(entry), entry.depth);
        in_bands(canvas, threads, &|band: &mut Band<'_>| {
            self.order.iter().filter(|entry| !in_front(entry)).for_each(|entry| self.draw(entry, band));
        });
        let behind = if self.liquid.is_deep() { canvas.pixels().to_vec() } else { Vec::new() };
        in_bands(canvas, threads, &|band: &mut Band<'_>| {
            self.liquid.paint(band, &behind);
            self.order.iter().filter(in_front).for_each(|entry| self.draw(entry, band));
        });
    }

    fn draw(&self, entry: &Entry, band: &mut Band<'_>) {
        match entry.shape {
            Shape::Disc(index) => {
                let disc = self.discs[index as usize];
                band.disc(disc);
                band.deepen_disc(&disc, entry.depth);
            }
            Shape::Line(index, mixing) => {
                let (line, depths) = self.lines[index as usize];
                band.line(line, mixing);
                if mixing == Mixing::Over {
                    band.deepen_line(&line, depths);
                }
            }
            Shape::Halo(index) => band.halo(self.halos[index as usize]),
            Shape::Triangle(index) => {
                let (triangle, texture, weave) = &self.triangles[index as usize];
                let texture = texture.map(|texture| &*self.textures[usize::from(texture)]);
                band.triangle(triangle, texture, weave.map(|weave| (&self.weaves[weave as usize], self.samples)));
            }
        }
    }

    /// Center of a shape [pixels].
    fn anchor(&self, entry: &Entry) -> [f32; 2] {
        match entry.shape {
            Shape::Disc(index) => self.discs[index as usize].center,
            Shape::Halo(index) => self.halos[index as usize].center,
            Shape::Line(index, _) => {
                let (Line { from, to, .. }, _) = self.lines[index as usize];
                [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])]
            }
            Shape::Triangle(index) => {
                let [a, b, c] = self.triangles[index as usize].0.corners;
                [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0]
            }
        }
    }

    fn add(&mut self, depth: f32, shape: Shape) {
        self.has_depth |= depth != 0.0;
        self.order.push(Entry { depth, shape });
    }
}

/// Number of threads worth using for `shapes` shapes.
fn threads(shapes: usize) -> usize {
    if shapes < FEW { 1 } else { available_parallelism().map_or(1, usize::from) }
}

/// Draws on all rows, divided among threads.
fn in_bands(canvas: &mut Canvas, threads: usize, draw: &(impl Fn(&mut Band<'_>) + Sync)) {
    std::thread::scope(|scope| {
        let mut bands = canvas.bands(threads);
        let mine = bands.next();
        for mut band in bands {
            scope.spawn(move || draw(&mut band));
        }
        mine.into_iter().for_each(|mut band| draw(&mut band));
    });
}
