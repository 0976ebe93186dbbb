//! The promises, at the process boundary: the real program, run as a person runs it.

mod acceptance;
mod architecture;
mod bad_input;
mod cabinet;
mod cases;
mod check;
mod clients;
mod examples;
mod kinfold;
mod make;
mod resume;
mod transcripts;
