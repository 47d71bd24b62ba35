//! What people look at: pictures, pages, and a scene in words.

pub mod describe;
pub mod render;
pub mod report;
