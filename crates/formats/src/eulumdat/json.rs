//! The header of an EULUMDAT document for the JSON documents.

use serde_json::{Map, Value, json};

use super::document::Document;
use super::fields::{Field, HEADER, SET, Value as Kept};

impl Document {
    /// Every field, for `header` of the JSON documents.
    pub(crate) fn header_json(&self) -> Map<String, Value> {
        let mut header = self.header.clone();
        let mut map = fields_json(HEADER, &mut header);
        let mut insert = |key: &str, value: Value| map.insert(key.to_owned(), value);
        insert("symmetry_indicator", self.isym.into());
        insert("c_planes", self.c_deg.len().into());
        insert("gamma_angles", self.gamma_deg.len().into());
        let sets = header.lamp_sets.iter_mut().map(|set| fields_json(SET, set));
        insert("lamp_sets", sets.collect());
        insert("direct_ratios", json!(header.direct_ratios));
        map
    }
}

fn fields_json<T>(fields: &[Field<T>], of: &mut T) -> Map<String, Value> {
    let value = |field: &Field<T>| match field.value {
        Kept::Text(place, _) => json!(place(of)),
        Kept::Number(_, _, place, _) => json!(place(of)),
    };
    let keys = fields.iter().map(|field| field.key.to_owned());
    keys.zip(fields.iter().map(value)).collect()
}
