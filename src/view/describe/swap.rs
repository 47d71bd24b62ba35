use crate::base::text::digits;
use crate::model::{Swap, SwapMoves};

/// Describes swap moves.
#[must_use]
pub fn swap(swap: &Swap) -> String {
    let attempts = match swap.attempts {
        Some(attempts) => format!("{attempts} swap moves"),
        None => "a swap move for each moving particle".to_owned(),
    };
    let ratio = swap
        .largest_ratio
        .map_or_else(String::new, |ratio| format!(", of diameters with a ratio of at most {}", digits(ratio)));
    format!("{attempts} at intervals of {}{ratio}", digits(swap.interval))
}

/// Describes the swap moves of a stage.
#[must_use]
pub fn swap_moves(moves: &SwapMoves) -> String {
    let accepted = moves.acceptance().map_or_else(String::new, |accepted| {
        let part = 100.0 * accepted;
        let part = if part == 0.0 || part >= 0.1 { format!("{part:.1}") } else { format!("{part:.1e}") };
        format!("; accepted between unlike particles: {part} %")
    });
    let too_unlike =
        if moves.too_unlike == 0 { String::new() } else { format!(", {} beyond the largest ratio", moves.too_unlike) };
    format!("{}{too_unlike}{accepted}", moves.attempted)
}
