//! Contacts: effects of impacts, friction and rest on a particle; no particle ever passes a wall.

mod height_fields;
mod impacts;
mod laboratory;
mod refusals;
mod resting;
mod spheres;
mod tunnelling;
