//! DEV: devices and channels of UAVs (`definitions/flockwave/dev.md`).

use std::collections::BTreeMap;

use uavspec_types::flockwave::json::{
    ChannelOperation, ChannelType, DeviceClass, DeviceTreeNode, DeviceTreeNodeType, DeviceTreePath,
    ObjectType, Request, dev_inf, dev_list, dev_listsub, dev_sub, dev_unsub,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::Outcomes;
use crate::request::each_once;

/// The maximum number of subscriptions per client.
const SUBSCRIPTION_LIMIT: usize = 10_000;

/// The maximum number of subscribed paths of all clients. Beyond this number, each client may still have
/// [`RESERVED_PATHS`].
const TOTAL_PATHS: usize = 50_000;

/// The number of paths to which each client may subscribe even if [`TOTAL_PATHS`] is reached.
const RESERVED_PATHS: usize = 8;

pub(super) fn answer(hub: &mut Hub, session: SessionId, request: Request) -> Answer {
    match request {
        Request::DevInf(request) => {
            let outcomes = Outcomes::collect(request.paths, |path| hub.world.values_at(path))?;
            let (values, error) = outcomes.into_maps();
            Ok(dev_inf::Response { values, error }.into())
        }
        Request::DevList(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| tree(hub, id))?;
            let (devices, error) = outcomes.into_maps();
            Ok(dev_list::Response { devices, error }.into())
        }
        Request::DevListsub(request) => subscriptions(hub, session, request),
        Request::DevSub(request) => {
            let outcomes = Outcomes::collect(request.paths, |path| subscribe(hub, session, path))?;
            let (success, error) = outcomes.into_list();
            Ok(dev_sub::Response { success, error }.into())
        }
        Request::DevUnsub(request) => unsubscribe(hub, session, request),
        other => Err(unknown(&other)),
    }
}

/// The device tree of an object.
fn tree(hub: &Hub, id: &str) -> Result<DeviceTreeNode, String> {
    let kind = hub.world.objects().find(|(known, _)| *known == id).map(|(_, kind)| kind);
    let children = (kind.ok_or("no such object")? == ObjectType::Uav).then(devices);
    Ok(DeviceTreeNode { children, ..node(DeviceTreeNodeType::Object) })
}

/// The devices of a UAV. [`World`](crate::world::World) provides their values.
fn devices() -> BTreeMap<String, DeviceTreeNode> {
    let battery = [
        ("voltage", channel(ChannelType::Number, Some("V"))),
        ("percentage", channel(ChannelType::Number, Some("%"))),
    ];
    let gps =
        [("satellites", channel(ChannelType::Number, None)), ("position", channel(ChannelType::Gps, None))];
    named([("battery", device(DeviceClass::Battery, battery)), ("gps", device(DeviceClass::Gps, gps))])
}

fn device(class: DeviceClass, channels: [(&str, DeviceTreeNode); 2]) -> DeviceTreeNode {
    let children = Some(named(channels));
    DeviceTreeNode { class: Some(class), children, ..node(DeviceTreeNodeType::Device) }
}

fn channel(kind: ChannelType, unit: Option<&str>) -> DeviceTreeNode {
    DeviceTreeNode {
        sub_type: Some(kind),
        operations: Some(vec![ChannelOperation::Read]),
        unit: unit.map(str::to_owned),
        ..node(DeviceTreeNodeType::Channel)
    }
}

/// A node that has only a type.
fn node(kind: DeviceTreeNodeType) -> DeviceTreeNode {
    DeviceTreeNode { r#type: kind, sub_type: None, class: None, children: None, operations: None, unit: None }
}

fn named(nodes: [(&str, DeviceTreeNode); 2]) -> BTreeMap<String, DeviceTreeNode> {
    nodes.into_iter().map(|(name, node)| (name.to_owned(), node)).collect()
}

fn subscribe(hub: &mut Hub, session: SessionId, path: &str) -> Result<(), String> {
    hub.world.values_at(path)?;
    let is_full = hub.subscribed >= TOTAL_PATHS;
    let session = hub.session(session).ok_or("the connection has ended")?;
    let is_exceeding = is_full && session.subscriptions.len() >= RESERVED_PATHS;
    if is_exceeding || session.subscriptions.values().sum::<usize>() >= SUBSCRIPTION_LIMIT {
        return Err("too many subscriptions".to_owned());
    }
    *session.subscriptions.entry(path.to_owned()).or_default() += 1;
    hub.subscribed += 1;
    Ok(())
}

fn unsubscribe(hub: &mut Hub, session: SessionId, request: dev_unsub::Request) -> Answer {
    let is_for_all = request.remove_all.unwrap_or_default();
    let has_subtrees = request.include_subtrees.unwrap_or_default();
    let session = hub.session(session).ok_or("the connection has ended")?;
    let mut outcomes = Outcomes::new();
    for path in each_once(request.paths)? {
        let is_meant = |known: &&String| **known == path || has_subtrees && is_below(known, &path);
        let found: Vec<String> = session.subscriptions.keys().filter(is_meant).cloned().collect();
        if found.is_empty() {
            outcomes.put(path, Err("no such subscription".to_owned()));
        }
        for path in found {
            let left = session.subscriptions.get_mut(&path).map_or(0, |count| {
                *count -= 1;
                *count
            });
            if is_for_all || left == 0 {
                session.subscriptions.remove(&path);
                session.last_sent.remove(&path);
            }
            outcomes.put(path, Ok(()));
        }
    }
    let (success, error) = outcomes.into_list();
    Ok(dev_unsub::Response { success, error }.into())
}

fn subscriptions(hub: &mut Hub, session: SessionId, request: dev_listsub::Request) -> Answer {
    let filters = request.path_filter.map(each_once).transpose()?;
    let session = hub.session(session).ok_or("the connection has ended")?;
    let mut paths = Vec::new();
    for (path, count) in &session.subscriptions {
        let fits = filters.as_ref().map_or(1, |filters| {
            filters.iter().filter(|filter| path == *filter || is_below(path, filter)).count()
        });
        paths.extend(std::iter::repeat_n(DeviceTreePath::from(path.as_str()), count * fits));
        if paths.len() > SUBSCRIPTION_LIMIT {
            return Err("the filters match too many subscriptions".to_owned());
        }
    }
    Ok(dev_listsub::Response { paths: Some(paths) }.into())
}

/// True if a path is below another.
fn is_below(path: &str, above: &str) -> bool {
    let above = above.strip_suffix('/').unwrap_or(above);
    path.strip_prefix(above).is_some_and(|rest| rest.starts_with('/'))
}
