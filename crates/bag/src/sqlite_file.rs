//! The SQLite files of rosbag2.

use std::path::{Path, PathBuf};

use rusqlite::{Connection, OpenFlags};

use crate::error::BagError;
use crate::storage::{Place, Seen, Storage, plain};
use crate::wire::Wire;

/// What the file begins with.
pub(crate) const MAGIC: &[u8] = b"SQLite format 3\0";

/// All messages with their topics.
const MESSAGES: &str = "SELECT messages.id, messages.timestamp, topics.name, topics.type, topics.serialization_format, messages.data \
     FROM messages JOIN topics ON messages.topic_id = topics.id ORDER BY messages.id";

pub(crate) struct SqliteFile {
    path: PathBuf,
    connection: Connection,
    /// Whether each message is packed by itself.
    is_packed: bool,
}

impl SqliteFile {
    pub(crate) fn open(path: &Path, is_packed: bool) -> Result<Self, BagError> {
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags).map_err(|error| broken(path, 0, &error))?;
        // A file that was cut short is refused as a whole, unless a broken schema is allowed: then its pages are read up to the cut.
        if connection.prepare(MESSAGES).is_err() {
            connection
                .pragma_update(None, "writable_schema", true)
                .map_err(|error| broken(path, 0, &error))?;
        }
        Ok(Self { path: path.to_path_buf(), connection, is_packed })
    }
}

fn broken(path: &Path, row: u64, reason: &dyn std::fmt::Display) -> BagError {
    BagError::Broken { path: path.to_path_buf(), at: row, reason: reason.to_string() }
}

impl Storage for SqliteFile {
    fn scan(&mut self, visit: &mut dyn FnMut(Seen<'_>)) -> Result<Option<String>, BagError> {
        let failed = |row: u64, error: &rusqlite::Error| broken(&self.path, row, error);
        let mut statement = self.connection.prepare(MESSAGES).map_err(|error| failed(0, &error))?;
        let mut rows = statement.query([]).map_err(|error| failed(0, &error))?;
        let mut last = 0;
        loop {
            let mut step = || -> Result<bool, String> {
                let text = |error: rusqlite::Error| error.to_string();
                let Some(row) = rows.next().map_err(text)? else { return Ok(false) };
                let (id, log_ns): (i64, i64) = (row.get(0).map_err(text)?, row.get(1).map_err(text)?);
                last = id.unsigned_abs();
                let (topic, type_name) = (row.get_ref(2).map_err(text)?, row.get_ref(3).map_err(text)?);
                let format = row.get_ref(4).map_err(text)?;
                let column = |value: rusqlite::types::ValueRef<'_>| value.as_str().unwrap_or("?").to_owned();
                if column(format) != "cdr" {
                    return Ok(true);
                }
                let data = row.get_ref(5).map_err(text)?.as_blob().map_err(|error| error.to_string())?;
                let data = &*plain(data, self.is_packed)?;
                let place = Place { file: 0, record: last, offset: 0, length: data.len() as u32 };
                let (topic, type_name) = (column(topic), column(type_name));
                visit(Seen { topic: &topic, type_name: &type_name, wire: Wire::Cdr, log_ns, place, data });
                Ok(true)
            };
            match step() {
                Ok(true) => {}
                Ok(false) => return Ok(None),
                Err(reason) => return broken(&self.path, last, &reason).ends_scan().map(Some),
            }
        }
    }

    fn read(&mut self, place: Place) -> Result<Vec<u8>, BagError> {
        let failed = |error: &dyn std::fmt::Display| broken(&self.path, place.record, error);
        let query = "SELECT data FROM messages WHERE id = ?1";
        let mut statement = self.connection.prepare_cached(query).map_err(|error| failed(&error))?;
        let row = i64::try_from(place.record).unwrap_or(i64::MAX);
        let data: Vec<u8> = statement.query_row([row], |row| row.get(0)).map_err(|error| failed(&error))?;
        Ok(plain(&data, self.is_packed).map_err(|error| failed(&error))?.into_owned())
    }
}
