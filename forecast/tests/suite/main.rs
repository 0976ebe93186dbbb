//! The forecast, from outside: its table, its files, and the engines that it speaks of.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::too_many_lines,
    reason = "a test that cannot go on says so and ends; tables of files are long"
)]

mod engines;
mod hostile;
mod peculiar;
mod peculiarities;
mod table;
