//! Families whose proportions are thrown with dice: the front towards −y, left and right as seen by
//! who stands before it.

mod desk;
mod fittings;
mod furniture;
mod house;
mod kitchen;
mod travel;
mod water;
mod workshop;

use super::draft::{Dice, Draft};

/// A family whose objects differ.
pub(super) struct Varied {
    pub(super) name: &'static str,
    pub(super) build: fn(&mut Dice) -> Draft,
}

const fn family(name: &'static str, build: fn(&mut Dice) -> Draft) -> Varied {
    Varied { name, build }
}

/// Every one of them.
pub(super) const VARIED: [Varied; 41] = [
    family("drawer_unit", furniture::drawer_unit),
    family("cupboard", furniture::cupboard),
    family("desk", furniture::desk),
    family("wardrobe", furniture::wardrobe),
    family("folding_table", furniture::folding_table),
    family("office_chair", furniture::office_chair),
    family("microwave", kitchen::microwave),
    family("oven", kitchen::oven),
    family("fridge", kitchen::fridge),
    family("dishwasher", kitchen::dishwasher),
    family("washing_machine", kitchen::washing_machine),
    family("stove", kitchen::stove),
    family("toaster", kitchen::toaster),
    family("door", house::door),
    family("casement_window", house::casement),
    family("sash_window", house::sash),
    family("light_switch", house::switch),
    family("ceiling_fan", house::ceiling_fan),
    family("storage_box", house::storage_box),
    family("waste_bin", house::waste_bin),
    family("laptop", desk::laptop),
    family("desk_lamp", desk::lamp),
    family("scissors", desk::scissors),
    family("stapler", desk::stapler),
    family("keypad", desk::keypad),
    family("globe", desk::globe),
    family("faucet", water::faucet),
    family("toilet", water::toilet),
    family("kettle", water::kettle),
    family("bottle", water::bottle),
    family("bicycle", travel::bicycle),
    family("suitcase", travel::suitcase),
    family("slot_lever", workshop::slot_lever),
    family("sliders", workshop::sliders),
    family("bolt", workshop::bolt),
    family("plunger", workshop::plunger),
    family("carriage", workshop::carriage),
    family("control_box", workshop::control_box),
    family("coffee_machine", fittings::coffee_machine),
    family("jar", fittings::jar),
    family("appliance", fittings::appliance),
];
