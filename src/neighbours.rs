//! Who is near whom: the search for the particles that one particle could meet.

pub mod cells;
