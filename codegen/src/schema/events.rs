//! The events of services, which ROS 2 records to make requests and responses visible.

use uavspec_runtime::Scalar;

use super::fingerprint;
use super::id::MessageId;
use super::model::{Element, Field, Form, Message, Package, Schema, Type};
use crate::msg::ast::Shape;
use crate::msg::{Dialect, Kind};
use crate::source::Span;

/// The fields of `service_msgs/msg/ServiceEventInfo`, without its time.
const INFO: [(&str, Scalar, Shape); 3] = [
    ("event_type", Scalar::UInt8, Shape::Single),
    ("client_gid", Scalar::Char, Shape::Array(16)),
    ("sequence_number", Scalar::Int64, Shape::Single),
];

impl Schema {
    /// Adds a message `<Name>_Event` for each service: the request, the response and information about the client. No
    /// package lists these messages: only recordings contain them.
    pub fn add_service_events(&mut self) {
        let services = (0..self.packages.len()).flat_map(|package| {
            let interfaces = self.packages[package].interfaces.iter();
            interfaces.filter_map(move |interface| match (interface.kind, interface.parts.as_slice()) {
                (Kind::Service, [request, response]) => {
                    Some((package, interface.name.clone(), [*request, *response], interface.span))
                }
                _ => None,
            })
        });
        let services: Vec<_> = services.collect();
        let Some((.., span)) = services.first() else { return };
        let info = self.event_info(*span);
        for (package, service, [request, response], span) in services {
            let at_most_one = Shape::Bounded(1);
            let fields = vec![
                field("info", Element::Message(info), Shape::Single, span),
                field("request", Element::Message(request), at_most_one, span),
                field("response", Element::Message(response), at_most_one, span),
            ];
            self.add_message(package, Kind::Service, format!("{service}_Event"), fields, span);
        }
    }

    /// The message `service_msgs/msg/ServiceEventInfo`, which is added if it isn't defined.
    fn event_info(&mut self, span: Span) -> MessageId {
        self.defined("service_msgs", "ServiceEventInfo").unwrap_or_else(|| {
            let time = self.defined("builtin_interfaces", "Time").unwrap_or_else(|| {
                let numbers = [("sec", Scalar::Int32), ("nanosec", Scalar::UInt32)];
                let fields = numbers.map(|(name, ty)| field(name, Element::Scalar(ty), Shape::Single, span));
                self.add_to_package("builtin_interfaces", "Time", fields.into(), span)
            });
            let fields = INFO.map(|(name, ty, shape)| field(name, Element::Scalar(ty), shape, span));
            let mut fields = Vec::from(fields);
            fields.insert(1, field("stamp", Element::Message(time), Shape::Single, span));
            self.add_to_package("service_msgs", "ServiceEventInfo", fields, span)
        })
    }

    fn defined(&self, ros_package: &str, name: &str) -> Option<MessageId> {
        let packages = self.packages.iter().filter(|package| package.ros_package == ros_package);
        packages.flat_map(|package| &package.messages).find(|id| self.message(**id).name == name).copied()
    }

    /// Adds a message to a new package.
    fn add_to_package(&mut self, package: &str, name: &str, fields: Vec<Field>, span: Span) -> MessageId {
        let form = Form::Msg(Dialect::Ros2);
        self.packages.push(Package::new(package.to_owned(), form, package.to_owned()));
        self.add_message(self.packages.len() - 1, Kind::Message, name.to_owned(), fields, span)
    }

    fn add_message(
        &mut self,
        package: usize,
        kind: Kind,
        name: String,
        fields: Vec<Field>,
        span: Span,
    ) -> MessageId {
        // The number of messages is limited when definitions are read.
        let id = MessageId(u32::try_from(self.messages.len()).unwrap_or(u32::MAX));
        self.messages.push(Message { fields, ..Message::new(package, kind, name, span) });
        self.nested_first.push(id);
        let type_hash = fingerprint::type_hash(self, id);
        if let Some(message) = self.messages.last_mut() {
            message.type_hash = type_hash;
        }
        id
    }
}

fn field(name: &str, element: Element, shape: Shape, span: Span) -> Field {
    Field::new(name.to_owned(), Type { element, shape }, span)
}
