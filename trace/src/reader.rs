//! Reads a trace, whole or torn: everything that was synced before a crash comes back.
//!
//! ```
//! # use trace::{Manifest, Recorder};
//! # let dir = tempfile::tempdir()?;
//! # let path = dir.path().join("trace.mcap");
//! # let (inputs, parameters) = Default::default();
//! # let (run_id, flow, version) = ("r".into(), "toy".into(), "1".into());
//! # let manifest = Manifest { run_id, flow, version, seed: 7, inputs, parameters };
//! # Recorder::create(&path, &manifest, 1)?.finish()?;
//! let reading = trace::read(&path)?;
//! assert_eq!(reading.manifest, Some(manifest));
//! assert!(reading.chain_holds && reading.torn.is_none());
//!
//! let half = trace::read_bytes(&std::fs::read(&path)?[..600], "half of it")?;
//! assert!(half.torn.is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
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

/// Most bytes of a trace file (1 GiB): a guess, a hundred times the largest seen.
pub const MAX_BYTES: u64 = 1 << 30;
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

/// Reads a trace file of at most [`MAX_BYTES`].
///
/// # Errors
/// [`TraceError::Refused`] when it cannot be opened or is no such file, [`TraceError::Foreign`] when
/// it is no trace of ours. A torn or damaged file is not an error: [`Reading::torn`] says where it ends.
pub fn read(path: &Path) -> Result<Reading, TraceError> {
    let name = path.display().to_string();
    let bytes = guard::files::read(path, MAX_BYTES);
    let bytes = bytes.map_err(|why| TraceError::Refused { path: name.clone(), why })?;
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
    // The MCAP library takes lengths for granted that a damaged record denies. What was collected
    // before it broke down is whole records only, so it may be kept.
    let walked = catch_unwind(AssertUnwindSafe(|| collector.walk(bytes)));
    let broken = || Err("the MCAP library broke down over a damaged record".to_owned());
    if let Err(found) = walked.unwrap_or_else(|_| broken()) {
        collector.reading.torn = Some(found);
    }
    Ok(collector.reading)
}

/// Most bytes a record of a trace of that length can unpack to: what compresses better than that is
/// no record of ours.
fn longest_record(length: usize) -> usize {
    length.saturating_mul(64).clamp(1 << 20, 1 << 30)
}

/// Most bytes all records of a trace of that length can unpack to, for the same reason.
fn longest_in_all(length: usize) -> u64 {
    (length as u64).saturating_mul(64).clamp(64 << 20, 4 << 30)
}

/// Bytes before the data of a record: its opcode and its length; MCAP's specification. A record of
/// nothing counts as much, or nothing would be endless.
const RECORD_HEAD: u64 = 9;

/// Whether the head of an attachment and its checksum fit into its record: the parser takes that for
/// granted. Two times, two texts with their lengths, the length of the data; MCAP's specification.
fn attachment_fits(record: &[u8]) -> bool {
    const CHECKSUM: usize = 4;
    let after_text = |at: usize| {
        let length: [u8; 4] = record.get(at..at.checked_add(4)?)?.try_into().ok()?;
        at.checked_add(4)?.checked_add(usize::try_from(u32::from_le_bytes(length)).ok()?)
    };
    let data = after_text(16).and_then(after_text).and_then(|at| at.checked_add(8));
    data.and_then(|at| at.checked_add(CHECKSUM)).is_some_and(|end| end <= record.len())
}

#[derive(Default)]
struct Collector {
    reading: Reading,
    channels: BTreeMap<u16, String>,
    /// Where each topic stands in the reading.
    places: BTreeMap<String, usize>,
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
        let (mut rest, mut unpacked, most) = (bytes, 0_u64, longest_in_all(bytes.len()));
        while let Some(event) = reader.next_event() {
            match event.map_err(|e| e.to_string())? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let (now, later) = rest.split_at(wanted.min(rest.len()));
                    reader.insert(now.len()).copy_from_slice(now);
                    reader.notify_read(now.len());
                    rest = later;
                }
                LinearReadEvent::Record { data, opcode } => {
                    unpacked += RECORD_HEAD + data.len() as u64;
                    if unpacked > most {
                        return Err(format!(
                            "its records unpack to more than {most} bytes, the most for its length"
                        ));
                    }
                    if opcode == mcap::records::op::ATTACHMENT && !attachment_fits(data) {
                        return Err("an attachment is shorter than its own head".into());
                    }
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
                if !self.places.contains_key(&channel.topic) {
                    self.places.insert(channel.topic.clone(), self.reading.topics.len());
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
        let place = self.places.get(topic).and_then(|&n| self.reading.topics.get_mut(n));
        if let Some((_, count)) = place {
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

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use std::io::Cursor;

    use mcap::records::MessageHeader;

    use super::*;

    /// A file of few bytes whose messages unpack to many.
    fn bomb(messages: u32, bytes: usize, topic: &str) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let options = mcap::WriteOptions::new().compression(Some(mcap::Compression::Zstd));
        let mut writer = options.create(&mut file).unwrap();
        let channel_id = writer.add_channel(0, topic, "json", &BTreeMap::new()).unwrap();
        let zeros = vec![0; bytes];
        for sequence in 0..messages {
            let header = MessageHeader { channel_id, sequence, log_time: 0, publish_time: 0 };
            writer.write_to_known_channel(&header, &zeros).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        file.into_inner()
    }

    /// A small chunk that unpacks to records of nothing had no end for hours.
    #[test]
    fn records_of_nothing_count_and_end() {
        let nothing = zstd::bulk::compress(&vec![0; 200 << 20], 1).unwrap();
        let mut chunk = Vec::new();
        chunk.extend([0_u64, 0, 200 << 20].map(u64::to_le_bytes).concat());
        chunk.extend(0_u32.to_le_bytes());
        chunk.extend(4_u32.to_le_bytes());
        chunk.extend(b"zstd");
        chunk.extend((nothing.len() as u64).to_le_bytes());
        chunk.extend(nothing);
        let mut file = mcap::MAGIC.to_vec();
        file.push(mcap::records::op::CHUNK);
        file.extend((chunk.len() as u64).to_le_bytes());
        file.extend(chunk);
        assert!(file.len() < 100_000);
        let torn = read_bytes(&file, "t").unwrap().torn.unwrap();
        assert!(torn.contains("the most for its length"), "{torn}");
    }

    #[test]
    fn a_file_that_unpacks_to_far_more_than_its_length_is_torn_where_it_goes_too_far() {
        for topic in ["/calls", "/other"] {
            let bytes = bomb(300, 1 << 20, topic);
            assert!(bytes.len() < 1 << 20, "{}", bytes.len());
            let reading = read_bytes(&bytes, "bomb").unwrap();
            let torn = reading.torn.unwrap();
            assert!(torn.contains("unpack to more than 67108864 bytes"), "{torn}");
            assert!(reading.calls.len() <= 64);
        }
    }

    #[test]
    fn one_record_that_unpacks_to_far_more_than_its_length_is_not_unpacked() {
        let bytes = bomb(1, 200 << 20, "/calls");
        let reading = read_bytes(&bytes, "bomb").unwrap();
        assert!(reading.torn.is_some() && reading.calls.is_empty(), "{:?}", reading.torn);
    }

    #[test]
    fn a_file_that_is_too_long_or_none_is_refused_with_the_rule() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("long");
        std::fs::File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(
            error.ends_with("has more than 1073741824 bytes, the most that is read"),
            "{error}"
        );
        let error = read(dir.path()).unwrap_err().to_string();
        assert!(error.ends_with("is no regular file"), "{error}");
    }

    #[test]
    fn an_attachment_that_is_cut_in_its_head_does_not_fit() {
        let text = |t: &str| [&(t.len() as u32).to_le_bytes()[..], t.as_bytes()].concat();
        let head = [&[0; 16][..], &text("a.json"), &text("application/json"), &[0; 8]].concat();
        let whole = [&head[..], &[0; 4]].concat();
        assert!(attachment_fits(&whole) && attachment_fits(&[&whole[..], &[7; 9]].concat()));
        assert!((0..whole.len()).all(|end| !attachment_fits(&whole[..end])));
        assert!(!attachment_fits(&[0xff; 64]));
    }
}
