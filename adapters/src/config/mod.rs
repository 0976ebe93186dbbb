//! `kinfold.toml`: who is asked for meshes and conditions, with what manners, for how much.

mod acts;
mod amounts;
mod generator;
pub mod known;
mod reading;
#[cfg(test)]
mod tests;
mod vlm;

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use trace::Digest;

pub use acts::{Draft, may_carry_keys};
pub use generator::GeneratorConfig;
pub use vlm::{VlmConfig, VlmProvider};

use crate::budget::{Account, Budget, Price};
use crate::net::gate::Rate;
use crate::net::redactor::{Redactor, in_address};
use crate::overheard::discreet;
use crate::recorded::{Builds as _, Written};
use crate::terms::{Policy, Purpose};
use crate::{AdapterError, Critic, ImageTo3d, Vlm, World};

/// Who is asked; a section left out is nobody.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Who makes meshes.
    pub image_to_3d: Option<GeneratorConfig>,
    /// Who says what the parts are.
    pub vlm: Option<VlmConfig>,
    /// The most that may be spent in all.
    #[serde(default)]
    pub budget: Budget,
    /// How each of them is treated.
    #[serde(default)]
    pub manners: Manners,
}

/// How each provider is treated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Manners {
    /// Whoever makes meshes.
    pub image_to_3d: Manner,
    /// Whoever says what the parts are.
    pub vlm: Manner,
}

/// How a provider is treated, and what the user's contract with it says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Manner {
    /// How much it is asked.
    pub rate: Rate,
    /// What it charges; needed where there is a budget in money.
    pub price: Option<Price>,
    /// What the contract allows besides what is known of its licence.
    pub allowed: Vec<Purpose>,
}

impl Config {
    /// The same as it may be kept in a trace: addresses without what may open doors.
    #[must_use]
    pub fn redacted(&self) -> Self {
        let mut config = self.clone();
        config.image_to_3d = config.image_to_3d.map(GeneratorConfig::redacted);
        config.vlm = config.vlm.map(VlmConfig::redacted);
        config
    }

    /// The same without the sections that a given file stands in for.
    #[must_use]
    pub fn without(self, mesh: bool, condition: bool) -> Self {
        let image_to_3d = self.image_to_3d.filter(|_| !mesh);
        Self { image_to_3d, vlm: self.vlm.filter(|_| !condition), ..self }
    }

    /// Who makes meshes; none if nobody is configured.
    ///
    /// # Errors
    /// [`AdapterError::Key`] where a key is needed and not set.
    pub fn image_to_3d(&self, world: &World) -> Result<Option<Box<dyn ImageTo3d>>, AdapterError> {
        let Some(config) = self.image_to_3d.clone() else { return Ok(None) };
        config.adapter(world)?;
        let manner = self.manners.image_to_3d.clone();
        let own_server = config.is_own_server();
        let account = Account { own_server, ..self.account(&manner, world) };
        let (rate, redactor) = (manner.rate, self.redactor(world));
        let onlooker = world.onlooker.clone();
        let onlooker = onlooker.map(|onlooker| discreet(onlooker, redactor.clone()));
        let world = World { onlooker, ..world.clone() };
        Ok(Some(Box::new(Written { config, world, rate, account, redactor })))
    }

    /// Who makes meshes, where they are spoken to; none if it is a program or nobody.
    pub(crate) fn spoken(&self, world: &World) -> Result<Option<Box<dyn ImageTo3d>>, AdapterError> {
        let spoken = self.image_to_3d.clone().and_then(generator::Spoken::of);
        let Some(config) = spoken else { return Ok(None) };
        config.adapter(world)?;
        let manner = self.manners.image_to_3d.clone();
        let account = self.account(&manner, world);
        let (world, rate, redactor) = (world.clone(), manner.rate, self.redactor(world));
        Ok(Some(Box::new(Written { config, world, rate, account, redactor })))
    }

    /// Who says what the parts are; none if nobody is configured.
    ///
    /// # Errors
    /// [`AdapterError::Key`] where a key is needed and not set.
    pub fn vlm(&self, world: &World) -> Result<Option<Box<dyn Vlm>>, AdapterError> {
        let Some(config) = self.vlm.clone() else { return Ok(None) };
        config.adapter(world)?;
        Ok(Some(Box::new(self.written_vlm(config, world))))
    }

    /// Who looks at what was made and flags what looks wrong; none unless `vlm.critic` is on.
    ///
    /// # Errors
    /// [`AdapterError::Key`] where a key is needed and not set.
    pub fn critic(&self, world: &World) -> Result<Option<Box<dyn Critic>>, AdapterError> {
        let Some(config) = self.vlm.clone().filter(|vlm| vlm.critic) else { return Ok(None) };
        config.adapter(world)?;
        Ok(Some(Box::new(self.written_vlm(config, world))))
    }

    fn written_vlm(&self, config: VlmConfig, world: &World) -> Written<VlmConfig> {
        let manner = &self.manners.vlm;
        let account = self.account(manner, world);
        let (world, rate, redactor) = (world.clone(), manner.rate, self.redactor(world));
        Written { config, world, rate, account, redactor }
    }

    /// The world as it is reached for a question to the model, with manners and on record.
    pub(crate) fn vlm_world(&self, config: &VlmConfig, world: &World, question: &Digest) -> World {
        self.written_vlm(config.clone(), world).world_for(question)
    }

    /// Refuses providers whose terms and a policy do not go together.
    ///
    /// # Errors
    /// [`AdapterError::Terms`], naming the provider and what is forbidden or not known.
    pub fn permit(&self, policy: &Policy) -> Result<(), AdapterError> {
        let generator = self.image_to_3d.as_ref();
        let generator = generator.map(|g| (g.name(), g.terms(), &self.manners.image_to_3d));
        let vlm = self.vlm.as_ref().map(|v| (v.name(), v.terms(), &self.manners.vlm));
        for (provider, terms, manner) in generator.into_iter().chain(vlm) {
            let refused = |found| AdapterError::Terms {
                provider: provider.to_owned(),
                policy: policy.to_string(),
                found,
            };
            terms.permit(policy, &manner.allowed).map_err(refused)?;
        }
        Ok(())
    }

    /// Takes everything secret that this configuration, or the environment of any provider, holds out
    /// of texts: keys, and what addresses hold besides a place.
    pub fn redactor(&self, world: &World) -> Redactor {
        let generator = self.image_to_3d.as_ref();
        let named = generator.into_iter().flat_map(|g| [g.key_variable(), g.id_variable()]);
        let named = named.chain(self.vlm.as_ref().map(VlmConfig::key_variable)).flatten();
        let variables: BTreeSet<&str> = named.chain(known::KEY_VARIABLES).collect();
        let keys = variables.into_iter().filter_map(|v| world.key(v).ok());
        let bases = generator.and_then(GeneratorConfig::base).into_iter();
        let bases = bases.chain(self.vlm.as_ref().map(VlmConfig::base));
        let secrets: Vec<_> = keys.chain(bases.flat_map(in_address)).collect();
        Redactor::new(&secrets)
    }

    fn account(&self, manner: &Manner, world: &World) -> Account {
        let (price, book) = (manner.price, Arc::clone(&world.book));
        Account { budget: self.budget, price, book, own_server: false }
    }
}
