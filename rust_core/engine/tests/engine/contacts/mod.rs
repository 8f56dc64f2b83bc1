//! Contacts: what an impact, friction and rest do to a particle, and that nothing ever passes a wall.

mod height_fields;
mod impacts;
mod laboratory;
mod refusals;
mod resting;
mod spheres;
mod tunnelling;
