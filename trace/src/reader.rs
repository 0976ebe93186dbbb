//! Reads a trace, whole or torn: everything that was synced before a crash comes back.

use std::path::Path;

use foxglove::Decode as _;
use foxglove::messages::CompressedImage;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::TraceError;
use crate::clock::Time;
use crate::digest::Digest;
use crate::event::{Manifest, StageEvent};
use crate::writer::{CALL_TOPIC, STAGE_TOPIC, VERDICT_TOPIC};

/// How topics begin that carry foxglove.CompressedImage.
const PICTURE_TOPICS: [&str; 2] = ["/input/", "/views/"];

/// What a trace holds.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// What the run was asked to do.
    pub manifest: Option<Manifest>,
    /// What happened, in order, with the time.
    pub events: Vec<(Time, StageEvent)>,
    /// Files kept whole.
    pub attachments: Vec<Kept>,
    /// Pictures, in order.
    pub pictures: Vec<Picture>,
    /// Calls to the world outside, in order: the JSON as it stands, which its digest names.
    pub calls: Vec<Vec<u8>>,
    /// Number of messages on each topic, in order of first use.
    pub topics: Vec<(String, u64)>,
    /// The verdict, as in `verdict.json`.
    pub verdict: Option<serde_json::Value>,
    /// Why reading stopped before the end, if it did: the file was torn or damaged there.
    pub torn: Option<String>,
    /// Whether each event names the digest of the one before it, and the first the manifest's.
    pub chain_holds: bool,
}

/// A file kept in a trace.
#[derive(Clone, Debug)]
pub struct Kept {
    /// Its name.
    pub name: String,
    /// Its media type.
    pub media_type: String,
    /// Its bytes, whose checksum was right.
    pub bytes: Vec<u8>,
}

/// A picture in a trace.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Its topic, such as `/views/front`.
    pub topic: String,
    /// Its file's bytes.
    pub bytes: Vec<u8>,
}

/// Reads a trace file.
///
/// # Errors
/// [`TraceError::Io`] when it cannot be opened, [`TraceError::Foreign`] when it is no trace of
/// ours. A torn or damaged file is not an error: [`Reading::torn`] says where it ends.
pub fn read(path: &Path) -> Result<Reading, TraceError> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path);
    let bytes = bytes.map_err(|source| TraceError::Io { path: name.clone(), source })?;
    read_bytes(&bytes, &name)
}

/// Reads a trace from memory; `name` stands in errors.
///
/// # Errors
/// [`TraceError::Foreign`] when the bytes are not the beginning of an MCAP file.
pub fn read_bytes(bytes: &[u8], name: &str) -> Result<Reading, TraceError> {
    let magic = mcap::MAGIC;
    let head = &bytes[..bytes.len().min(magic.len())];
    if head != &magic[..head.len()] || bytes.is_empty() {
        let (path, found) = (name.into(), format!("bytes {head:02x?}"));
        return Err(TraceError::Foreign { path, expected: "the MCAP magic", found });
    }
    let mut collector = Collector::default();
    if let Err(found) = collector.walk(bytes) {
        collector.reading.torn = Some(found);
    }
    Ok(collector.reading)
}

/// Most bytes a record of a trace of that length can unpack to: what compresses better than that is
/// no record of ours.
fn longest_record(length: usize) -> usize {
    length.saturating_mul(64).clamp(1 << 20, 1 << 30)
}

#[derive(Default)]
struct Collector {
    reading: Reading,
    channels: std::collections::BTreeMap<u16, String>,
    last_event: Option<Digest>,
    broken_chain: bool,
}

impl Collector {
    fn walk(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.reading.chain_holds = true;
        let options = LinearReaderOptions::default().with_validate_chunk_crcs(true);
        // A damaged length must not ask for more memory than any record can need.
        let options = options.with_record_length_limit(longest_record(bytes.len()));
        let mut reader = LinearReader::new_with_options(options);
        let mut rest = bytes;
        while let Some(event) = reader.next_event() {
            match event.map_err(|e| e.to_string())? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let (now, later) = rest.split_at(wanted.min(rest.len()));
                    reader.insert(now.len()).copy_from_slice(now);
                    reader.notify_read(now.len());
                    rest = later;
                }
                LinearReadEvent::Record { data, opcode } => {
                    let record = mcap::parse_record(opcode, data).map_err(|e| e.to_string())?;
                    self.take(record)?;
                }
            }
        }
        Ok(())
    }

    fn take(&mut self, record: Record<'_>) -> Result<(), String> {
        match record {
            Record::Channel(channel) => {
                if !self.channels.contains_key(&channel.id) {
                    self.reading.topics.push((channel.topic.clone(), 0));
                }
                self.channels.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => {
                self.message(header.channel_id, header.log_time, &data)?
            }
            // Parsing has checked the checksum.
            Record::Attachment { header, data, .. } => {
                self.attachment(header.name, header.media_type, data.into_owned());
            }
            _ => {}
        }
        Ok(())
    }

    fn message(&mut self, channel: u16, at: Time, data: &[u8]) -> Result<(), String> {
        let topic =
            self.channels.get(&channel).ok_or(format!("channel {channel} is undeclared"))?;
        if let Some((_, count)) = self.reading.topics.iter_mut().find(|(t, _)| t == topic) {
            *count += 1;
        }
        if topic == STAGE_TOPIC {
            let event: StageEvent = serde_json::from_slice(data).map_err(|e| e.to_string())?;
            self.broken_chain |= event.previous != self.last_event;
            self.last_event = Some(Digest::of(data));
            self.reading.chain_holds = !self.broken_chain;
            self.reading.events.push((at, event));
        } else if topic == VERDICT_TOPIC {
            self.reading.verdict = serde_json::from_slice(data).ok();
        } else if topic == CALL_TOPIC {
            self.reading.calls.push(data.to_vec());
        } else if PICTURE_TOPICS.iter().any(|t| topic.starts_with(t)) {
            let picture = CompressedImage::decode(data).map_err(|e| e.to_string())?;
            let (topic, bytes) = (topic.clone(), picture.data.to_vec());
            self.reading.pictures.push(Picture { topic, bytes });
        }
        Ok(())
    }

    fn attachment(&mut self, name: String, media_type: String, bytes: Vec<u8>) {
        if name == "manifest.json" {
            self.last_event = Some(Digest::of(&bytes));
            self.reading.manifest = serde_json::from_slice(&bytes).ok();
        }
        self.reading.attachments.push(Kept { name, media_type, bytes });
    }
}
