//! EXT: extensions of the server (`definitions/flockwave/ext.md`).

use std::collections::BTreeMap;

use serde_json::Value;
use uavspec_types::flockwave::json::{
    ExtensionId, ExtensionInfo, Request, ext_cfg, ext_inf, ext_list, ext_load, ext_reload, ext_setcfg,
    ext_unload,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::{Outcomes, text};
use crate::world::Extension;

/// The maximum length of a configuration, in characters of JSON.
const CONFIGURATION_LIMIT: usize = 4096;

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::ExtList(_) => Ok(list(hub).into()),
        Request::ExtCfg(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| Ok(find(hub, id)?.configuration.clone()))?;
            let (status, error) = outcomes.into_maps();
            Ok(ext_cfg::Response { status, error }.into())
        }
        Request::ExtInf(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| {
                let Extension { is_loaded, name, .. } = *find(hub, id)?;
                let (id, name) = (id.into(), name.to_owned());
                Ok(ExtensionInfo { id, loaded: is_loaded, name, description: None })
            })?;
            let (status, error) = outcomes.into_maps();
            Ok(ext_inf::Response { status, error }.into())
        }
        Request::ExtLoad(request) => {
            let (status, error) =
                Outcomes::collect(request.ids, |id| load(find(hub, id)?, true))?.into_maps();
            Ok(ext_load::Response { status, error }.into())
        }
        Request::ExtUnload(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| match id {
                "simulation" => Err("the server requires this extension".to_owned()),
                _ => load(find(hub, id)?, false),
            })?;
            let (status, error) = outcomes.into_maps();
            Ok(ext_unload::Response { status, error }.into())
        }
        Request::ExtReload(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| {
                let is_loaded = find(hub, id)?.is_loaded;
                is_loaded.then(BTreeMap::new).ok_or_else(|| "the extension isn't loaded".to_owned())
            })?;
            let (status, error) = outcomes.into_maps();
            Ok(ext_reload::Response { status, error }.into())
        }
        Request::ExtSetcfg(request) => Ok(configure(hub, request).into()),
        other => Err(unknown(&other)),
    }
}

fn list(hub: &Hub) -> ext_list::Response {
    let ids = |is_loaded: bool| -> Vec<ExtensionId> {
        let extensions = hub.world.extensions.iter();
        extensions
            .filter(|(_, extension)| extension.is_loaded == is_loaded)
            .map(|(id, _)| ExtensionId::from(*id))
            .collect()
    };
    ext_list::Response { loaded: ids(true), available: ids(false) }
}

fn find<'h>(hub: &'h mut Hub, id: &str) -> Result<&'h mut Extension, String> {
    hub.world.extensions.get_mut(id).ok_or_else(|| "no such extension".to_owned())
}

fn load(extension: &mut Extension, is_loaded: bool) -> Result<BTreeMap<String, Value>, String> {
    if extension.is_loaded == is_loaded {
        return Err(if is_loaded { "the extension is already loaded" } else { "the extension isn't loaded" }
            .to_owned());
    }
    extension.is_loaded = is_loaded;
    Ok(BTreeMap::new())
}

fn configure(hub: &mut Hub, request: ext_setcfg::Request) -> ext_setcfg::Response {
    let mut outcomes = Outcomes::new();
    for (id, configuration) in request.ids {
        let is_long = text(&configuration).len() > CONFIGURATION_LIMIT;
        let outcome = match find(hub, &id) {
            Ok(_) if is_long => {
                Err(format!("the configuration has more than {CONFIGURATION_LIMIT} characters"))
            }
            Ok(extension) => {
                extension.configuration = configuration;
                Ok(BTreeMap::new())
            }
            Err(error) => Err(error),
        };
        outcomes.put(id, outcome);
    }
    let (status, error) = outcomes.into_maps();
    ext_setcfg::Response { status, error }
}
