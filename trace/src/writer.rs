//! Writes a trace: manifest first, then events, pictures, scenes and joints; synced per stage.
//!
//! ```
//! use trace::{Manifest, Recorder};
//!
//! # let dir = tempfile::tempdir()?;
//! # let path = dir.path().join("trace.mcap");
//! # let (inputs, parameters) = Default::default();
//! # let (run_id, flow, version) = ("r".into(), "toy".into(), "1".into());
//! let manifest = Manifest { run_id, flow, version, seed: 7, inputs, parameters };
//! let mut recorder = Recorder::create(&path, &manifest, 1)?;
//! recorder.attach("lid.obj", "model/obj", b"v 0 0 0", 2)?;
//! recorder.joints(&[("hinge".to_owned(), 0.5)], 3)?;
//! recorder.finish()?;
//!
//! let reading = trace::read(&path)?;
//! let lid = reading.attachments.iter().find(|kept| kept.name == "lid.obj");
//! assert_eq!(lid.map(|kept| kept.bytes.as_slice()), Some(&b"v 0 0 0"[..]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use foxglove::Encode;
use foxglove::messages as fm;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, WriteOptions, Writer};
use serde::Serialize;

use crate::TraceError;
use crate::clock::Time;
use crate::digest::Digest;
use crate::event::{Manifest, StageEvent};
use crate::seal;

/// Topic of stage events (JSON, [`StageEvent`]).
pub const STAGE_TOPIC: &str = "/stage";
/// Topic of the verdict (JSON, as in `verdict.json`).
pub const VERDICT_TOPIC: &str = "/verdict";
/// Topic of calls to the world outside (JSON, one request and what came of it).
pub const CALL_TOPIC: &str = "/calls";
/// Topic of log lines (foxglove.Log).
pub const LOG_TOPIC: &str = "/log";
/// Topic of the asset's links as models (foxglove.SceneUpdate).
pub const SCENE_TOPIC: &str = "/scene";
/// Topic of link poses (foxglove.FrameTransforms).
pub const TRANSFORM_TOPIC: &str = "/tf";
/// Topic of joint values (foxglove.JointStates).
pub const JOINT_TOPIC: &str = "/joints";

/// Writes one trace file. Times given must not decrease.
pub struct Recorder {
    writer: Writer<BufWriter<File>>,
    file: File,
    path: String,
    sequence: u32,
    channels: BTreeMap<String, u16>,
    last_event: Option<Digest>,
}

/// A link's model, drawn in the link's own frame.
#[derive(Clone, Debug)]
pub struct SceneLink {
    /// Name of the link and of its frame.
    pub frame: String,
    /// Its surface as a GLB file (y up, as GLB demands), metres.
    pub glb: Vec<u8>,
}

/// Where a frame stands in its parent.
#[derive(Clone, Debug)]
pub struct Transform {
    /// Parent frame.
    pub parent: String,
    /// Child frame.
    pub child: String,
    /// Metres.
    pub translation: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
}

/// How loud a log line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// For the record.
    Info,
    /// Something was lost or is doubtful.
    Warning,
    /// Something failed.
    Error,
}

/// What a topic carries.
struct Channel<'a> {
    topic: &'a str,
    schema: &'a str,
    schema_encoding: &'a str,
    schema_data: &'a [u8],
    message_encoding: &'a str,
}

impl Recorder {
    /// Creates the file and writes the manifest, as metadata `run` and attachment `manifest.json`.
    ///
    /// # Errors
    /// [`TraceError::Io`] or [`TraceError::Mcap`] when the disk refuses.
    pub fn create(path: &Path, manifest: &Manifest, at: Time) -> Result<Self, TraceError> {
        let name = path.display().to_string();
        let io = |source| TraceError::Io { path: name.clone(), source };
        let file = File::create(path).map_err(io)?;
        let twin = file.try_clone().map_err(io)?;
        // With its own threads zstd gives other bytes than without. Most of a trace is pictures, of
        // which a higher level gets nothing.
        let options = WriteOptions::new().compression_threads(0).compression_level(1);
        let options = options.profile("").library("kinfold");
        let writer = options.create(BufWriter::new(file));
        let writer = writer.map_err(|source| TraceError::Mcap { path: name.clone(), source })?;
        let (channels, last_event) = (BTreeMap::new(), None);
        let mut this = Self { writer, file: twin, path: name, sequence: 0, channels, last_event };
        this.write_manifest(manifest, at)?;
        Ok(this)
    }

    fn write_manifest(&mut self, manifest: &Manifest, at: Time) -> Result<(), TraceError> {
        let bytes = encode_json("manifest.json", manifest)?;
        self.last_event = Some(Digest::of(&bytes));
        let facts = [
            ("run_id", manifest.run_id.clone()),
            ("flow", manifest.flow.clone()),
            ("version", manifest.version.clone()),
            ("seed", manifest.seed.to_string()),
        ];
        let mut metadata: BTreeMap<_, _> =
            facts.into_iter().map(|(k, v)| (k.to_string(), v)).collect();
        metadata.extend(manifest.inputs.iter().map(|(k, d)| (format!("input.{k}"), d.to_string())));
        let record = Metadata { name: "run".into(), metadata };
        self.check(|w| w.write_metadata(&record))?;
        self.attach("manifest.json", "application/json", &bytes, at)?;
        self.sync()
    }

    /// Records what happened to a stage, chained to the event before it, the first to the manifest.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn stage(&mut self, event: &StageEvent, at: Time) -> Result<(), TraceError> {
        let event = StageEvent { previous: self.last_event.clone(), ..event.clone() };
        let bytes = encode_json(STAGE_TOPIC, &event)?;
        self.last_event = Some(Digest::of(&bytes));
        let schema = schemars::schema_for!(StageEvent).to_value();
        self.put_json((STAGE_TOPIC, "kinfold.StageEvent"), &schema, &bytes, at)
    }

    /// Records the verdict as it stands in `verdict.json`.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn verdict(&mut self, json: &serde_json::Value, at: Time) -> Result<(), TraceError> {
        let bytes = encode_json(VERDICT_TOPIC, json)?;
        let schema = serde_json::json!({ "type": "object", "title": "kinfold.Verdict" });
        self.put_json((VERDICT_TOPIC, "kinfold.Verdict"), &schema, &bytes, at)
    }

    /// Records one call to the world outside on the topic `/calls`; returns the digest by which a
    /// stage's event names it.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn call(
        &mut self,
        call: &impl Serialize,
        schema: &serde_json::Value,
        at: Time,
    ) -> Result<Digest, TraceError> {
        let bytes = encode_json(CALL_TOPIC, call)?;
        self.put_json((CALL_TOPIC, "kinfold.Call"), schema, &bytes, at)?;
        Ok(Digest::of(&bytes))
    }

    /// Keeps a whole file.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn attach(
        &mut self,
        name: &str,
        media_type: &str,
        bytes: &[u8],
        at: Time,
    ) -> Result<(), TraceError> {
        let attachment = Attachment {
            log_time: at,
            create_time: at,
            name: name.into(),
            media_type: media_type.into(),
            data: Cow::Borrowed(bytes),
        };
        self.check(|w| w.attach(&attachment))
    }

    /// Records a picture (`format`: `png`, `jpeg` or `webp`) as foxglove.CompressedImage.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn image(
        &mut self,
        topic: &str,
        format: &str,
        bytes: &[u8],
        at: Time,
    ) -> Result<(), TraceError> {
        let message = fm::CompressedImage {
            timestamp: Some(stamp(at)),
            frame_id: "world".into(),
            data: bytes.to_vec().into(),
            format: format.into(),
        };
        self.put(topic, &message, at)
    }

    /// Records a log line as foxglove.Log.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn log(&mut self, severity: Severity, text: &str, at: Time) -> Result<(), TraceError> {
        let level = match severity {
            Severity::Info => fm::log::Level::Info,
            Severity::Warning => fm::log::Level::Warning,
            Severity::Error => fm::log::Level::Error,
        };
        let message = fm::Log {
            timestamp: Some(stamp(at)),
            level: level as i32,
            message: guard::text::shown(text).into_owned(),
            name: "kinfold".into(),
            ..Default::default()
        };
        self.put(LOG_TOPIC, &message, at)
    }

    /// Records every link's model as foxglove.SceneUpdate, each in its own frame.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn scene(&mut self, links: &[SceneLink], at: Time) -> Result<(), TraceError> {
        let entities = links.iter().map(|l| scene_entity(l, at)).collect();
        self.put(SCENE_TOPIC, &fm::SceneUpdate { deletions: vec![], entities }, at)
    }

    /// Records where frames stand as foxglove.FrameTransforms.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn transforms(&mut self, frames: &[Transform], at: Time) -> Result<(), TraceError> {
        let one = |t: &Transform| {
            let ([x, y, z], [i, j, k, w]) = (t.translation, t.rotation);
            fm::FrameTransform {
                timestamp: Some(stamp(at)),
                parent_frame_id: t.parent.clone(),
                child_frame_id: t.child.clone(),
                translation: Some(fm::Vector3 { x, y, z }),
                rotation: Some(fm::Quaternion { x: i, y: j, z: k, w }),
            }
        };
        let transforms = frames.iter().map(one).collect();
        self.put(TRANSFORM_TOPIC, &fm::FrameTransforms { transforms }, at)
    }

    /// Records joint positions (radians or metres) as foxglove.JointStates.
    ///
    /// # Errors
    /// [`TraceError`] when it cannot be written.
    pub fn joints(&mut self, values: &[(String, f64)], at: Time) -> Result<(), TraceError> {
        let one = |(name, q): &(String, f64)| fm::JointState {
            name: name.clone(),
            position: Some(*q),
            ..Default::default()
        };
        let joints = values.iter().map(one).collect();
        self.put(JOINT_TOPIC, &fm::JointStates { timestamp: Some(stamp(at)), joints }, at)
    }

    /// Closes the open chunk and waits until the disk has it all.
    ///
    /// # Errors
    /// [`TraceError`] when the disk refuses.
    pub fn sync(&mut self) -> Result<(), TraceError> {
        self.check(|w| w.flush())?;
        let path = self.path.clone();
        self.file.sync_data().map_err(|source| TraceError::Io { path, source })
    }

    /// Seals the trace, writes the summary and closes the file.
    ///
    /// # Errors
    /// [`TraceError`] when the disk refuses.
    pub fn finish(mut self) -> Result<(), TraceError> {
        self.sync()?;
        let io = |source| TraceError::Io { path: self.path.clone(), source };
        let seal = seal::content(&std::fs::read(&self.path).map_err(io)?);
        self.check(|w| w.write_private_record(seal::OPCODE, &seal, Default::default()))?;
        self.check(|w| w.finish().map(drop))?;
        self.file.sync_all().map_err(|source| TraceError::Io { path: self.path.clone(), source })
    }

    fn put<M: Encode>(&mut self, topic: &str, message: &M, at: Time) -> Result<(), TraceError> {
        let what = std::any::type_name::<M>();
        let failed = |found: String| TraceError::Encode { topic: topic.into(), what, found };
        let schema = M::get_schema().ok_or_else(|| failed("it has no schema".into()))?;
        let mut bytes = Vec::new();
        message.encode(&mut bytes).map_err(|e| failed(e.to_string()))?;
        let channel = Channel {
            topic,
            schema: &schema.name,
            schema_encoding: &schema.encoding,
            schema_data: &schema.data,
            message_encoding: &M::get_message_encoding(),
        };
        self.write(&channel, &bytes, at)
    }

    fn put_json(
        &mut self,
        (topic, name): (&str, &str),
        schema: &serde_json::Value,
        bytes: &[u8],
        at: Time,
    ) -> Result<(), TraceError> {
        let schema = encode_json(topic, schema)?;
        let channel = Channel {
            topic,
            schema: name,
            schema_encoding: "jsonschema",
            schema_data: &schema,
            message_encoding: "json",
        };
        self.write(&channel, bytes, at)
    }

    fn write(&mut self, channel: &Channel<'_>, bytes: &[u8], at: Time) -> Result<(), TraceError> {
        let channel_id = match self.channels.get(channel.topic) {
            Some(&id) => id,
            None => self.open(channel)?,
        };
        self.sequence += 1;
        let (sequence, log_time, publish_time) = (self.sequence, at, at);
        let header = MessageHeader { channel_id, sequence, log_time, publish_time };
        self.check(|w| w.write_to_known_channel(&header, bytes))
    }

    fn open(&mut self, channel: &Channel<'_>) -> Result<u16, TraceError> {
        let Channel { topic, schema, schema_encoding, schema_data, message_encoding } = *channel;
        let id = self.check(|w| {
            let schema = w.add_schema(schema, schema_encoding, schema_data)?;
            w.add_channel(schema, topic, message_encoding, &BTreeMap::new())
        })?;
        self.channels.insert(topic.into(), id);
        Ok(id)
    }

    fn check<T>(
        &mut self,
        f: impl FnOnce(&mut Writer<BufWriter<File>>) -> Result<T, mcap::McapError>,
    ) -> Result<T, TraceError> {
        f(&mut self.writer).map_err(|source| TraceError::Mcap { path: self.path.clone(), source })
    }
}

fn scene_entity(link: &SceneLink, at: Time) -> fm::SceneEntity {
    // GLB is y up, the link's frame is z up: a quarter turn about x stands the model upright.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let rotation = fm::Quaternion { x: half, y: 0.0, z: 0.0, w: half };
    let pose = fm::Pose { position: Some(fm::Vector3::default()), orientation: Some(rotation) };
    let model = fm::ModelPrimitive {
        pose: Some(pose),
        scale: Some(fm::Vector3 { x: 1.0, y: 1.0, z: 1.0 }),
        media_type: "model/gltf-binary".into(),
        data: link.glb.clone().into(),
        ..Default::default()
    };
    fm::SceneEntity {
        timestamp: Some(stamp(at)),
        frame_id: link.frame.clone(),
        id: link.frame.clone(),
        frame_locked: true,
        models: vec![model],
        ..Default::default()
    }
}

fn stamp(at: Time) -> fm::Timestamp {
    let seconds = u32::try_from(at / 1_000_000_000).unwrap_or(u32::MAX);
    fm::Timestamp::new(seconds, (at % 1_000_000_000) as u32)
}

fn encode_json(topic: &str, value: &impl Serialize) -> Result<Vec<u8>, TraceError> {
    let failed = |e: serde_json::Error| TraceError::Encode {
        topic: topic.into(),
        what: "JSON",
        found: e.to_string(),
    };
    serde_json::to_vec(value).map_err(failed)
}
