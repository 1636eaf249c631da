//! CDR encoder.

use std::ops::ControlFlow;

use uavspec_runtime::Fault;
use uavspec_runtime::cdr::{ByteOrder, HEADER};
use uavspec_schema::Element;

use crate::bytes::{copy, part, slot};
use crate::error::{Error, Reason};
use crate::plan::{Field, Plan, SLOT};
use crate::step::{Bounds, Run, Sequence, Step, Width};
use crate::text::code_units;
use crate::trail::Trail;
use crate::types::Types;
use crate::view::DynamicView;
use crate::walk::{Stop, Walk, walk};

/// Encodes a message as a CDR payload.
pub(crate) fn encode(view: DynamicView<'_>, order: ByteOrder) -> Result<Vec<u8>, Error> {
    let payload = match order {
        ByteOrder::LittleEndian => write::<false>(view, order),
        ByteOrder::BigEndian => write::<true>(view, order),
    };
    payload.ok_or_else(|| refuse(view))
}

fn write<const BIG: bool>(view: DynamicView<'_>, order: ByteOrder) -> Option<Vec<u8>> {
    // The CDR form is rarely larger than the memory form plus the header.
    let mut out = Vec::with_capacity(view.bytes.len().saturating_sub(view.base) + HEADER);
    out.extend_from_slice(&order.header());
    let mut writer = Writer::<BIG> { types: view.types, bytes: view.bytes, out };
    writer.message(view.plan, view.base)?;
    Some(writer.out)
}

struct Writer<'b, const BIG: bool> {
    types: &'b Types,
    bytes: &'b [u8],
    /// The payload, preceded by its four-byte header, which is not counted when values are aligned.
    out: Vec<u8>,
}

impl<const BIG: bool> Writer<'_, BIG> {
    /// Pads to a multiple of the width, counted from the end of the header.
    #[inline]
    fn align(&mut self, width: Width) {
        let gap = (HEADER.wrapping_sub(self.out.len())) & (width as usize - 1);
        if gap > 0 {
            self.out.extend_from_slice(&[0; 8][..gap]);
        }
    }

    /// Writes the message at `base`.
    fn message(&mut self, plan: &Plan, base: usize) -> Option<()> {
        for step in &plan.steps {
            match *step {
                Step::Copy(Run { offset, size, width, is_bool }) => {
                    self.numbers(base + offset, size, width, is_bool);
                }
                Step::Strings { offset, count, bounds } => self.strings(base + offset, count, bounds)?,
                Step::Messages { offset, count, plan } => self.messages(base + offset, count, plan)?,
                Step::Sequence { offset, bound, element } => self.sequence(base + offset, bound, element)?,
                Step::Empty => self.out.push(0),
            }
        }
        Some(())
    }

    #[inline]
    fn numbers(&mut self, from: usize, size: usize, width: Width, is_bool: bool) {
        let bytes = part(self.bytes, from, size);
        self.align(width);
        if is_bool {
            self.out.extend(bytes.iter().map(|byte| u8::from(*byte != 0)));
        } else if BIG && width != Width::One {
            let start = self.out.len();
            self.out.resize(start + bytes.len(), 0);
            copy::<BIG>(bytes, &mut self.out[start..], width);
        } else {
            self.out.extend_from_slice(bytes);
        }
    }

    fn messages(&mut self, from: usize, count: usize, plan: usize) -> Option<()> {
        let plan = &self.types.plans[plan];
        (0..count).try_for_each(|index| self.message(plan, from + index * plan.size.padded))
    }

    fn strings(&mut self, from: usize, count: usize, bounds: Bounds) -> Option<()> {
        (0..count).try_for_each(|index| self.string(from + index * SLOT, bounds))
    }

    fn length(&mut self, length: usize) -> Option<()> {
        let length = u32::try_from(length).ok()?;
        self.align(Width::Four);
        self.out.extend_from_slice(&if BIG { length.to_be_bytes() } else { length.to_le_bytes() });
        Some(())
    }

    fn sequence(&mut self, at: usize, bound: Option<u32>, element: Sequence) -> Option<()> {
        let (start, count) = slot(self.bytes, at);
        if bound.is_some_and(|bound| count > bound as usize) {
            return None;
        }
        self.length(count)?;
        match element {
            Sequence::Numbers { .. } if count == 0 => {}
            Sequence::Numbers { width, is_bool } => {
                self.numbers(start, count * width as usize, width, is_bool);
            }
            Sequence::Strings(bounds) => self.strings(start, count, bounds)?,
            Sequence::Messages(plan) => self.messages(start, count, plan)?,
        }
        Some(())
    }

    fn string(&mut self, at: usize, bounds: Bounds) -> Option<()> {
        let (start, length) = slot(self.bytes, at);
        let text = part(self.bytes, start, length);
        if bounds.exceeded_by(text).is_some() {
            return None;
        }
        if bounds.is_wide {
            let units = code_units(text)?;
            self.length(units.len())?;
            for unit in units {
                let unit = u32::from(unit);
                self.out.extend_from_slice(&if BIG { unit.to_be_bytes() } else { unit.to_le_bytes() });
            }
        } else {
            if text.contains(&0) {
                return None;
            }
            self.length(text.len() + 1)?;
            self.out.extend_from_slice(text);
            self.out.push(0);
        }
        Some(())
    }
}

/// The fault that prevents CDR from representing a string, if any. [`Writer::string`] refuses the same strings.
fn fault(text: &[u8], bounds: Bounds) -> Option<Fault> {
    if let Some((bound, found)) = bounds.exceeded_by(text) {
        return Some(Fault::TooLong { bound, found });
    }
    if bounds.is_wide {
        return code_units(text).is_none().then_some(Fault::NotUnicode);
    }
    text.contains(&0).then_some(Fault::Nul)
}

/// Finds the reason why a message has no CDR form.
#[cold]
fn refuse(view: DynamicView<'_>) -> Error {
    let mut search = Search { message: &view.plan.name, found: None };
    // The walk finds nothing if the cause is a length that exceeds 32 bits.
    let _ = walk(view, &mut Trail::default(), &mut search);
    search.found.unwrap_or_else(|| Error {
        reason: Reason::TooLarge,
        path: view.plan.name.to_string(),
        offset: None,
    })
}

struct Search<'v> {
    message: &'v str,
    found: Option<Error>,
}

impl<'v> Walk<'v> for Search<'v> {
    fn enters(&self, _: &[Plan], _: &Field) -> bool {
        true
    }

    fn stop(&mut self, trail: &Trail<'v>, field: &'v Field, stop: Stop<'v>) -> ControlFlow<()> {
        let fault = match (stop, field.element) {
            (Stop::String(text), Element::String { wide, bound }) => {
                fault(text, Bounds { is_wide: wide, bound })
            }
            (Stop::Length(found), _) => {
                let exceeded = field.bound().filter(|bound| found > *bound as usize);
                exceeded.map(|bound| Fault::TooLong { bound, found })
            }
            _ => None,
        };
        match fault {
            None => ControlFlow::Continue(()),
            Some(fault) => {
                let path = trail.text(self.message);
                self.found = Some(Error { reason: Reason::Fault(fault), path, offset: None });
                ControlFlow::Break(())
            }
        }
    }
}
