//! The messages that ROS 2 derives from services and actions.

use uavspec_runtime::Scalar;

use super::fingerprint;
use super::id::MessageId;
use super::model::{Element, Field, Form, Interface, Message, Package, Schema, Type};
use crate::msg::ast::Shape;
use crate::msg::{Dialect, Kind};
use crate::source::Span;

/// The fields of `service_msgs/msg/ServiceEventInfo`, without its time.
const INFO: [(&str, Scalar, Shape); 3] = [
    ("event_type", Scalar::UInt8, Shape::Single),
    ("client_gid", Scalar::Char, Shape::Array(16)),
    ("sequence_number", Scalar::Int64, Shape::Single),
];

/// The suffixes of the messages that ROS 2 derives from a service.
const OF_SERVICE: [&str; 3] = ["_Event", "_Request", "_Response"];

/// The suffixes of the messages that ROS 2 derives from an action: from its two services, its feedback and its parts.
/// No suffix ends with an earlier suffix.
const OF_ACTION: [&str; 10] = [
    "_SendGoal_Event",
    "_SendGoal_Request",
    "_SendGoal_Response",
    "_GetResult_Event",
    "_GetResult_Request",
    "_GetResult_Response",
    "_FeedbackMessage",
    "_Feedback",
    "_Goal",
    "_Result",
];

/// The service or action from which ROS 2 derives the message with the full name `name`: `sky_msgs/action/Land` for
/// `sky_msgs/action/Land_FeedbackMessage`.
///
/// ```
/// use uavspec_schema::{msg::Kind, derived_from};
///
/// assert_eq!(derived_from("sky_msgs/srv/Soar_Event"), Some((Kind::Service, "sky_msgs/srv/Soar")));
/// assert_eq!(derived_from("sky_msgs/msg/Soar_Event"), None);
/// ```
pub fn derived_from(name: &str) -> Option<(Kind, &str)> {
    let (folder, _) = name.rsplit_once('/')?;
    let (kind, suffixes) = match folder.rsplit_once('/')?.1 {
        "srv" => (Kind::Service, &OF_SERVICE[..]),
        "action" => (Kind::Action, &OF_ACTION[..]),
        _ => return None,
    };
    let origin = suffixes.iter().find_map(|suffix| name.strip_suffix(suffix))?;
    Some((kind, origin))
}

impl Schema {
    /// Adds the messages that ROS 2 derives from services and actions: an event for each service, and the requests,
    /// responses, events and feedback for each action. No package lists these messages; only captures contain them.
    pub fn add_derived(&mut self) {
        let mut derivation = Derivation { schema: self, info: None, time: None, uuid: None };
        for package in 0..derivation.schema.packages.len() {
            let interfaces = derivation.schema.packages[package].interfaces.iter();
            let found: Vec<_> = interfaces
                .map(|Interface { kind, name, parts, span, .. }| (*kind, name.clone(), parts.clone(), *span))
                .collect();
            for (kind, name, parts, span) in found {
                let place = Place { package, kind, span };
                match (kind, &parts[..]) {
                    (Kind::Service, [request, response]) => {
                        derivation.add_event(place, &name, [*request, *response]);
                    }
                    (Kind::Action, [goal, result, feedback]) => {
                        derivation.add_action(place, &name, [*goal, *result, *feedback]);
                    }
                    _ => {}
                }
            }
        }
    }

    fn defined(&self, ros_package: &str, name: &str) -> Option<MessageId> {
        let packages = self.packages.iter().filter(|package| package.ros_package == ros_package);
        packages.flat_map(|package| &package.messages).find(|id| self.message(**id).name == name).copied()
    }

    fn add_message(&mut self, place: Place, name: String, fields: Vec<Field>) -> MessageId {
        let Place { package, kind, span } = place;
        // The reader limits the number of messages, so this conversion can't fail.
        let id = MessageId(u32::try_from(self.messages.len()).unwrap_or(u32::MAX));
        self.messages.push(Message { fields, ..Message::new(package, kind, name, span) });
        self.topological_order.push(id);
        let type_hash = fingerprint::type_hash(self, id);
        if let Some(message) = self.messages.last_mut() {
            message.type_hash = type_hash;
        }
        id
    }

    /// Adds a message to a new package.
    fn add_to_package(&mut self, package: &str, name: &str, fields: Vec<Field>, span: Span) -> MessageId {
        let form = Form::Msg(Dialect::Ros2);
        let package = Package::new(package.to_owned(), form, package.to_owned());
        self.packages.push(Package { is_dependency: true, ..package });
        let place = Place { package: self.packages.len() - 1, kind: Kind::Message, span };
        self.add_message(place, name.to_owned(), fields)
    }
}

/// Adds the derived messages to a schema, with the messages of ROS 2 that they contain.
struct Derivation<'s> {
    schema: &'s mut Schema,
    info: Option<MessageId>,
    time: Option<MessageId>,
    uuid: Option<MessageId>,
}

impl Derivation<'_> {
    /// Adds the event of a service: the request, the response and information about the client.
    fn add_event(&mut self, place: Place, service: &str, [request, response]: [MessageId; 2]) {
        let info = self.info(place.span);
        let at_most_one = Shape::Bounded(1);
        let fields = vec![
            place.field("info", Element::Message(info), Shape::Single),
            place.field("request", Element::Message(request), at_most_one),
            place.field("response", Element::Message(response), at_most_one),
        ];
        self.schema.add_message(place, format!("{service}_Event"), fields);
    }

    /// Adds the messages of an action: the messages of the services that send a goal and get a result, and the
    /// feedback.
    fn add_action(&mut self, place: Place, action: &str, [goal, result, feedback]: [MessageId; 3]) {
        let single = |name, element| place.field(name, element, Shape::Single);
        let (id, time) = (Element::Message(self.uuid(place.span)), Element::Message(self.time(place.span)));
        let request = vec![single("goal_id", id), single("goal", Element::Message(goal))];
        let response = vec![single("accepted", Element::Scalar(Scalar::Bool)), single("stamp", time)];
        self.add_service(place, &format!("{action}_SendGoal"), [request, response]);
        let response =
            vec![single("status", Element::Scalar(Scalar::Int8)), single("result", Element::Message(result))];
        self.add_service(place, &format!("{action}_GetResult"), [vec![single("goal_id", id)], response]);
        let fields = vec![single("goal_id", id), single("feedback", Element::Message(feedback))];
        self.schema.add_message(place, format!("{action}_FeedbackMessage"), fields);
    }

    /// Adds the request, the response and the event of a service.
    fn add_service(&mut self, place: Place, service: &str, [request, response]: [Vec<Field>; 2]) {
        let request = self.schema.add_message(place, format!("{service}_Request"), request);
        let response = self.schema.add_message(place, format!("{service}_Response"), response);
        self.add_event(place, service, [request, response]);
    }

    /// Returns the id of `service_msgs/msg/ServiceEventInfo`, and adds this message if it isn't
    /// defined.
    fn info(&mut self, span: Span) -> MessageId {
        if let Some(known) = self.info.or_else(|| self.schema.defined("service_msgs", "ServiceEventInfo")) {
            return *self.info.insert(known);
        }
        let time = self.time(span);
        let fields = INFO.map(|(name, ty, shape)| field(name, Element::Scalar(ty), shape, span));
        let mut fields = Vec::from(fields);
        fields.insert(1, field("stamp", Element::Message(time), Shape::Single, span));
        *self.info.insert(self.schema.add_to_package("service_msgs", "ServiceEventInfo", fields, span))
    }

    /// Returns the id of `builtin_interfaces/msg/Time`, and adds this message if it isn't defined.
    fn time(&mut self, span: Span) -> MessageId {
        let known = self.time.or_else(|| self.schema.defined("builtin_interfaces", "Time"));
        *self.time.insert(known.unwrap_or_else(|| {
            let numbers = [("sec", Scalar::Int32), ("nanosec", Scalar::UInt32)];
            let fields = numbers.map(|(name, ty)| field(name, Element::Scalar(ty), Shape::Single, span));
            self.schema.add_to_package("builtin_interfaces", "Time", fields.into(), span)
        }))
    }

    /// Returns the id of `unique_identifier_msgs/msg/UUID`, and adds this message if it isn't
    /// defined.
    fn uuid(&mut self, span: Span) -> MessageId {
        let known = self.uuid.or_else(|| self.schema.defined("unique_identifier_msgs", "UUID"));
        *self.uuid.insert(known.unwrap_or_else(|| {
            let fields = vec![field("uuid", Element::Scalar(Scalar::UInt8), Shape::Array(16), span)];
            self.schema.add_to_package("unique_identifier_msgs", "UUID", fields, span)
        }))
    }
}

/// The location of a derived message.
#[derive(Clone, Copy)]
struct Place {
    package: usize,
    kind: Kind,
    /// The service or action.
    span: Span,
}

impl Place {
    fn field(self, name: &str, element: Element, shape: Shape) -> Field {
        field(name, element, shape, self.span)
    }
}

fn field(name: &str, element: Element, shape: Shape, span: Span) -> Field {
    Field::new(name.to_owned(), Type { element, shape }, span)
}
