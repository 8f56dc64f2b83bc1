//! Systems: a state with its law of motion.

pub mod matter;
