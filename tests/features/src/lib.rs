//! This package has no code, only the features in `Cargo.toml`.
