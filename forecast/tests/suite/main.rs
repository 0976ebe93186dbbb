//! The forecast, from outside: its table, its files, and the engines that it speaks of.

mod engines;
mod hostile;
mod peculiar;
mod peculiarities;
mod table;
