//! Compilation of definitions to plans.

use std::sync::OnceLock;

use uavspec_runtime::Scalar;
use uavspec_runtime::layout::{self, Member, Size};
use uavspec_schema::limits::MAX_MESSAGE_SIZE;
use uavspec_schema::source::Span;
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Message, Schema, Shape};

use super::error::Defect;
use super::plan::{Field, GROWTH, Plan, SLOT};
use super::types::Types;
use crate::limits::MAX_DEPTH;

/// A type before its layout is computed.
#[derive(Debug)]
pub(super) struct Draft {
    pub(super) package: Box<str>,
    pub(super) name: Box<str>,
    pub(super) span: Span,
    /// Fields in declaration order, without offsets and strides.
    pub(super) fields: Vec<Field>,
    pub(super) placement: Placement,
    /// Maximum size in bytes.
    pub(super) limit: u64,
    pub(super) defect: Option<Defect>,
}

/// The memory layout of fields.
#[derive(Clone, Copy, Debug)]
pub(super) enum Placement {
    /// The uORB layout, with alignment and reordering.
    Uorb,
    /// Contiguous in declaration order. Padding fields are removed afterwards.
    AsGiven,
}

/// Name prefix of padding fields, followed by a number.
pub(super) const PADDING: &str = "_padding";

impl Types {
    /// Compiles the types of all messages of a schema.
    pub fn new(schema: &Schema) -> Self {
        Self::of(compile(drafts(schema)))
    }
}

/// Creates a draft of each message, in the order of the schema.
fn drafts(schema: &Schema) -> Vec<Draft> {
    schema.messages.iter().map(|message| draft(schema, message)).collect()
}

fn draft(schema: &Schema, message: &Message) -> Draft {
    let is_too_large = message.cdr.min > MAX_MESSAGE_SIZE;
    Draft {
        package: schema.package_of(message).name.as_str().into(),
        name: message.name.as_str().into(),
        span: message.span,
        fields: fields_of(schema, message),
        placement: Placement::Uorb,
        limit: MAX_MESSAGE_SIZE * GROWTH as u64,
        defect: is_too_large.then_some(Defect::TooLarge(MAX_MESSAGE_SIZE)),
    }
}

fn fields_of(schema: &Schema, message: &Message) -> Vec<Field> {
    let mut counted_by = vec![None; message.fields.len()];
    for (index, field) in message.fields.iter().enumerate() {
        if let Some(array) = field.counts {
            counted_by[array] = counted_by[array].or(Some(index));
        }
    }
    let field = |(field, counted_by): (&uavspec_schema::Field, Option<usize>)| Field {
        default: field.default.clone(),
        restriction: schema.restriction(message, field),
        special: field.special_values(),
        counts: field.counts,
        counted_by,
        span: field.span,
        ..Field::new(&field.name, field.ty.element, field.ty.shape)
    };
    message.fields.iter().zip(counted_by).map(field).collect()
}

impl Field {
    pub(super) fn new(name: &str, element: Element, shape: Shape) -> Self {
        Self {
            name: name.into(),
            element,
            shape,
            offset: 0,
            stride: 0,
            restriction: None,
            special: Vec::new(),
            counts: None,
            counted_by: None,
            span: Span::default(),
            default: None,
            is_restricted: false,
        }
    }
}

/// Compiles the plans. Each message is compiled after the messages nested in it.
pub(super) fn compile(drafts: Vec<Draft>) -> Vec<Plan> {
    let depths = depths(&drafts);
    let mut order: Vec<usize> = (0..drafts.len()).filter(|index| depths[*index].is_some()).collect();
    order.sort_by_key(|index| depths[*index]);
    let mut plans: Vec<Plan> = drafts.iter().map(|draft| unusable(draft, Defect::Recursive)).collect();
    let mut drafts: Vec<Option<Draft>> = drafts.into_iter().map(Some).collect();
    for index in order {
        let Some(draft) = drafts[index].take() else { continue };
        let is_too_deep = depths[index] > Some(MAX_DEPTH);
        let defect = if is_too_deep { Some(Defect::TooDeep(MAX_DEPTH)) } else { defect(&draft, &plans) };
        plans[index] = match defect {
            Some(defect) => with_fields(unusable(&draft, defect), draft),
            None => plan(draft, &plans),
        };
    }
    plans
}

/// Nesting depth of each message, or `None` if it is recursive.
fn depths(drafts: &[Draft]) -> Vec<Option<usize>> {
    let mut missing = vec![0_usize; drafts.len()];
    let mut parents = vec![Vec::new(); drafts.len()];
    for (index, draft) in drafts.iter().enumerate() {
        for nested in nested(&draft.fields) {
            missing[index] += 1;
            parents[nested].push(index);
        }
    }
    let mut ready: Vec<usize> = (0..drafts.len()).filter(|index| missing[*index] == 0).collect();
    let mut depths = vec![None; drafts.len()];
    while let Some(index) = ready.pop() {
        depths[index] = nested(&drafts[index].fields)
            .filter_map(|nested| depths[nested])
            .max()
            .map_or(Some(0), |depth: usize| Some(depth + 1));
        for parent in std::mem::take(&mut parents[index]) {
            missing[parent] -= 1;
            if missing[parent] == 0 {
                ready.push(parent);
            }
        }
    }
    depths
}

fn nested(fields: &[Field]) -> impl Iterator<Item = usize> {
    fields.iter().filter_map(|field| match field.element {
        Element::Message(id) => Some(id.0 as usize),
        Element::Scalar(_) | Element::Text(_) | Element::String { .. } => None,
    })
}

fn defect(draft: &Draft, plans: &[Plan]) -> Option<Defect> {
    let mut nested = nested(&draft.fields).map(|nested| &plans[nested]);
    let nested_defect =
        nested.find(|nested| nested.defect.is_some()).map(|nested| Defect::Holds(nested.name.to_string()));
    draft.defect.clone().or(nested_defect)
}

fn unusable(draft: &Draft, defect: Defect) -> Plan {
    Plan {
        package: draft.package.clone(),
        name: draft.name.clone(),
        span: draft.span,
        fields: Box::default(),
        size: Size { padded: 0, no_padding: 0 },
        is_fixed: true,
        min: 0,
        has_defaults: false,
        has_bools: false,
        is_restricted: false,
        defect: Some(defect),
        transfer: OnceLock::new(),
    }
}

/// Adds the fields of a draft to a plan, because checks of JSON messages need the fields.
fn with_fields(plan: Plan, draft: Draft) -> Plan {
    Plan { fields: draft.fields.into(), ..plan }
}

fn plan(mut draft: Draft, plans: &[Plan]) -> Plan {
    let size = place(&mut draft, plans);
    if size.padded as u64 > draft.limit {
        let limit = draft.limit;
        return with_fields(unusable(&draft, Defect::TooLarge(limit)), draft);
    }
    for field in &mut draft.fields {
        field.is_restricted = is_restricted(field, plans);
    }
    let fields = &draft.fields;
    let any = |in_field: fn(&Field) -> bool, in_plan: fn(&Plan) -> bool| {
        fields.iter().any(in_field) || nested(fields).any(|nested| in_plan(&plans[nested]))
    };
    let varies = |field: &Field| field.is_sequence() || matches!(field.element, Element::String { .. });
    Plan {
        size,
        is_fixed: !any(varies, |plan| !plan.is_fixed),
        min: fields.iter().fold(0_usize, |all, field| all.saturating_add(min_size(field, plans))).max(1),
        has_defaults: any(|field| field.default.as_ref().is_some_and(is_nonzero), |plan| plan.has_defaults),
        has_bools: any(|field| field.element == Element::Scalar(Scalar::Bool), |plan| plan.has_bools),
        is_restricted: fields.iter().any(|field| field.is_restricted),
        defect: None,
        transfer: OnceLock::new(),
        package: draft.package,
        name: draft.name,
        span: draft.span,
        fields: draft.fields.into(),
    }
}

/// True if a default contains a nonzero byte.
fn is_nonzero(value: &Value) -> bool {
    match value {
        Value::Bool(value) => *value,
        Value::Int(value) => *value != 0,
        Value::Float(value) => value.to_bits() != 0,
        Value::Text(value) => !value.is_empty(),
        Value::List(values) => !values.is_empty(),
    }
}

/// Computes offsets and strides, and removes padding fields.
fn place(draft: &mut Draft, plans: &[Plan]) -> Size {
    let members: Vec<Member> = draft.fields.iter().map(|field| member(field, plans)).collect();
    let mut offsets = vec![0; members.len()];
    let size = match draft.placement {
        Placement::Uorb => layout::place(&members, &mut offsets),
        Placement::AsGiven => place_as_given(&draft.fields, &members, &mut offsets),
    };
    for ((field, member), offset) in draft.fields.iter_mut().zip(&members).zip(offsets) {
        field.offset = offset;
        field.stride = match field.element {
            Element::Message(id) => plans[id.0 as usize].size.padded,
            Element::Scalar(scalar) => scalar.size(),
            Element::String { .. } => SLOT,
            Element::Text(_) => member.size(),
        };
    }
    if matches!(draft.placement, Placement::AsGiven) {
        draft.fields.retain(|field| !field.name.starts_with(PADDING));
    }
    size
}

fn member(field: &Field, plans: &[Plan]) -> Member {
    let slot = |count| Member { element_size: SLOT, count, is_nested: false };
    match field.element {
        _ if field.is_sequence() => slot(1),
        Element::String { .. } => slot(field.count()),
        Element::Text(length) => Member { element_size: 1, count: length as usize, is_nested: false },
        Element::Scalar(scalar) => {
            Member { element_size: scalar.size(), count: field.count(), is_nested: false }
        }
        Element::Message(id) => {
            Member { element_size: plans[id.0 as usize].size.padded, count: field.count(), is_nested: true }
        }
    }
}

fn place_as_given(fields: &[Field], members: &[Member], offsets: &mut [usize]) -> Size {
    let mut size = Size { padded: 0, no_padding: 0 };
    for ((field, member), offset) in fields.iter().zip(members).zip(offsets) {
        *offset = size.padded;
        size.padded = size.padded.saturating_add(member.size());
        if !field.name.starts_with(PADDING) {
            size.no_padding = size.padded;
        }
    }
    size
}

fn min_size(field: &Field, plans: &[Plan]) -> usize {
    const COUNT: usize = 4;
    match field.element {
        _ if field.is_sequence() => COUNT,
        Element::String { .. } => COUNT * field.count(),
        Element::Text(length) => length as usize,
        Element::Scalar(scalar) => scalar.size() * field.count(),
        Element::Message(id) => plans[id.0 as usize].min.saturating_mul(field.count()),
    }
}

/// True if the field can contain a value that violates a rule.
fn is_restricted(field: &Field, plans: &[Plan]) -> bool {
    field.bound().is_some()
        || match field.element {
            Element::Scalar(_) => field.restriction.is_some(),
            Element::Text(_) | Element::String { .. } => true,
            Element::Message(id) => plans[id.0 as usize].is_restricted,
        }
}
