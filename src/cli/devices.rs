//! `pacinian devices`.

use super::failure::Failure;
use super::patience;
use super::table::{Table, grouped};
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::device::choose::{VIRTUAL, VIRTUAL_NAME, played_by_default};
use pacinian::io::device::failure::Trouble;
use pacinian::io::device::hosts::Hosts;
use pacinian::io::device::list::{Found, Offer};
use pacinian::io::device::missing::{JOINING, Machine};
use pacinian::io::device::rates::Rates;
use pacinian::io::device::servers::Server;
use pacinian::io::knob::ports;
use pacinian::io::midi_in;
use pacinian::text::problem::escaped;
use serde_json::json;

/// Lists sound cards (channels, rates, blocks), ports of MIDI, and what is missing
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pacinian devices\n  pacinian play PATCH --device \"USB Sound\"\n\n\
    A device is meant by its id, its name, or a part of its name that no other has. Where several hosts have it, that of the first \
    listed here is meant; one of another is `HOST:NAME`, and `HOST` alone is its default (*). `virtual` is a card that keeps real time \
    and plays to nobody.\n\nOne session plays on one device; what this prints ends with how several are joined into one.")]
pub struct Devices {
    /// As one JSON object, with all names
    #[arg(long)]
    json: bool,

    /// ALSA's further names for its cards (plughw, default, front), and its converters, too
    #[arg(long)]
    all: bool,
}

/// A sound system: its name, whether it runs, and its devices or why there are none.
type Place = (String, bool, Result<Vec<Found>, String>);

/// All sound systems, and the device that is heard where nobody names one.
fn everywhere() -> (Vec<Place>, Option<String>) {
    let place = |host: pacinian::io::device::hosts::Place| {
        let found = host.devices().map(|all| all.into_iter().map(|(_, found)| found).collect());
        (host.name.clone(), host.runs(), found.map_err(|error| error.to_string()))
    };
    let places: Vec<Place> = Hosts::default().places().map(place).collect();
    // A system may name one that it does not have.
    let there = |id: &String| {
        let mut all = places.iter().filter_map(|(.., found)| found.as_ref().ok()).flatten();
        all.any(|found| found.id == *id && found.input.is_some())
    };
    let heard = Hosts::default().default_input().filter(there);
    (places, heard)
}

impl Devices {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let (hosts, heard) = patience::look(None, terminal, everywhere)?;
        let played = played_by_default(hosts.iter().filter_map(|(.., found)| found.as_deref().ok()));
        let fallback = played.is_none();
        let servers = Server::all();
        let machine = Machine::this();
        if self.json {
            let hosts: Vec<_> =
                hosts.iter().map(|(name, runs, found)| host_as_json(name, *runs, found)).collect();
            let (ports, trouble) = match midi_in::names() {
                Ok(ports) => (ports, None),
                Err(why) => (Vec::new(), Some(why)),
            };
            let object = |(what, fix): &(&str, &str)| json!({ "what": what, "fix": fix });
            let advice: Vec<_> = machine.lacks().iter().map(object).collect();
            let joining: Vec<_> =
                JOINING.iter().map(|(with, how)| json!({ "with": with, "how": how })).collect();
            let midi = json!({ "ports": ports, "trouble": trouble });
            let said = json!({
                "pacinian": env!("CARGO_PKG_VERSION"),
                "real_time_priority": machine.real_time,
                "hosts": hosts,
                "virtual": { "id": VIRTUAL, "name": VIRTUAL_NAME, "default": fallback },
                "default_output": played.map_or(VIRTUAL, |found| &found.id),
                "default_input": heard,
                "servers": servers,
                "midi": midi,
                "advice": advice,
                "joining": joining,
                "serial_ports": serial_ports(),
            });
            return terminal.print(&format!("{said:#}\n"));
        }
        let mut text = String::new();
        for (name, runs, found) in
            hosts.iter().filter(|(name, runs, _)| *runs || !servers.iter().any(|server| server.is(name)))
        {
            text += &terminal.out.bold(name);
            match (runs, found) {
                (false, _) => text += ": does not run\n",
                (true, Err(error)) => text += &format!(": {}\n", escaped(error)),
                (true, Ok(found)) if found.is_empty() => text += ": no device\n",
                (true, Ok(found)) => text += &format!("\n{}", table(found, self.all)),
            }
        }
        text += &format!("{}\n{}\n", terminal.out.bold("virtual"), of_virtual(fallback));
        if let Some(found) = played {
            text += &format!("{}: {}\n", terminal.out.bold("played by default"), escaped(&found.id));
        }
        if let Some(id) = heard {
            text += &format!("{}: {}\n", terminal.out.bold("heard by default"), escaped(&id));
        }
        text += &match midi_in::names() {
            Ok(ports) if ports.is_empty() => format!("{}: no port\n", terminal.out.bold("MIDI")),
            Ok(ports) => {
                let mut table = Table::default();
                ports.into_iter().for_each(|port| table.row([escaped(&port)]));
                format!("{}\n{}", terminal.out.bold("MIDI"), table.text())
            }
            Err(why) => format!("{}: {}\n", terminal.out.bold("MIDI"), escaped(&why)),
        };
        let (ports, mut table) = (ports::list(), Table::default());
        let has_ports = !ports.is_empty();
        for port in ports {
            let usb = port.usb.map_or(String::new(), |usb| escaped(&usb.to_string()).into_owned());
            let knob = port.knob.map_or(String::new(), |knob| knob.to_string());
            table.row([escaped(&port.path).into_owned(), usb, knob]);
        }
        if has_ports {
            text += &format!("{}\n{}", terminal.out.bold("serial ports"), table.text());
        }
        for server in servers {
            let how = if server.runs { "runs" } else { "does not run" };
            text += &format!("{}: {how}\n", terminal.out.bold(server.name));
            if !server.help.is_empty() {
                let what = match (server.runs, server.built_in) {
                    (_, true) => "start it",
                    (true, false) => "reach it by its own channels",
                    (false, false) => "where it is to be used, a build that knows it",
                };
                text += &format!("  {what}: {}\n", server.help);
            }
        }
        for (what, help) in machine.lacks() {
            text += &format!("\n{what}\n  {help}\n");
        }
        text += "\nSeveral cards as one (docs/cards.md has the files and the commands)\n";
        JOINING.iter().for_each(|(with, how)| text += &format!("  {with}: {how}\n"));
        terminal.print(&text)
    }
}

/// Serial ports, of which a knob may hang on one.
fn serial_ports() -> Vec<serde_json::Value> {
    let port = |port: ports::Found| {
        let (usb, knob) = (port.usb.map(|usb| usb.to_string()), port.knob.map(|knob| knob.to_string()));
        json!({ "path": port.path, "usb": usb, "knob": knob })
    };
    ports::list().into_iter().map(port).collect()
}

/// What is said of the virtual card; `fallback` says whether it is played on where nobody names another.
fn of_virtual(fallback: bool) -> &'static str {
    match fallback {
        true => {
            "  * keeps real time and plays to nobody: --device virtual; `play` takes it where no device is named"
        }
        false => "  keeps real time and plays to nobody: --device virtual",
    }
}

fn host_as_json(name: &str, runs: bool, found: &Result<Vec<Found>, String>) -> serde_json::Value {
    let offer = |offer: &Option<Offer>| {
        offer.as_ref().map(|o| {
            json!({
                "channels": o.channels, "has": o.there, "rates": o.rates.iter().map(|(least, most)| [least, most]).collect::<Vec<_>>(),
                "blocks": o.blocks.map(|(least, most)| [least, most]), "formats": o.formats,
            })
        })
    };
    let device = |f: &Found| json!({ "id": f.id, "name": f.name, "default": f.default, "output": offer(&f.output), "input": offer(&f.input), "trouble": f.trouble.as_ref().map(|trouble| &trouble.what), "help": f.trouble.as_ref().and_then(|trouble| trouble.help.as_ref()) });
    let (devices, trouble) = match found {
        Ok(all) => (all.iter().map(device).collect(), None),
        Err(error) => (Vec::new(), Some(error)),
    };
    json!({ "name": name, "runs": runs, "devices": devices, "trouble": trouble })
}

fn table(found: &[Found], all: bool) -> String {
    let mut table = Table::default();
    table.row(["", "name", "outputs", "inputs", "rates", "blocks", "id"]);
    let (shown, others): (Vec<_>, Vec<_>) =
        found.iter().partition(|device| all || device.default || device.is_itself());
    for device in shown {
        let offer = device.output.as_ref().or(device.input.as_ref());
        let channels = |offer: &Option<Offer>| offer.as_ref().map_or("-".into(), |o| counts(&o.channels));
        let trouble = device.trouble.as_ref().map_or("", |trouble| match trouble.kind {
            Trouble::Busy => "in use",
            _ => "not allowed",
        });
        let rates = offer.map_or(trouble.to_string(), |o| of_rates(&o.rates));
        let blocks = offer.and_then(|o| o.blocks).map_or(String::new(), range);
        table.row([
            if device.default { "*" } else { "" }.to_string(),
            escaped(&device.name).into_owned(),
            channels(&device.output),
            channels(&device.input),
            rates,
            blocks,
            escaped(&device.id).into_owned(),
        ]);
    }
    table.text() + &further(&others) + &remedies(found)
}

/// How many names are not shown, and the first few of their kinds.
fn further(others: &[&Found]) -> String {
    if others.is_empty() {
        return String::new();
    }
    let mut kinds: Vec<&str> = Vec::new();
    for kind in others.iter().filter_map(|found| found.id.split(':').nth(1)) {
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    let more = if kinds.len() > 4 { ", ..." } else { "" };
    kinds.truncate(4);
    format!(
        "  and {} further names of cards and converters ({}{more}): devices --all\n",
        others.len(),
        kinds.join(", ")
    )
}

/// What helps against each trouble, once for all that have the same.
fn remedies(found: &[Found]) -> String {
    let mut all: Vec<(&str, Vec<String>)> = Vec::new();
    for device in found {
        let Some(help) = device.trouble.as_ref().and_then(|trouble| trouble.help.as_deref()) else {
            continue;
        };
        let name = escaped(&device.name).into_owned();
        match all.iter_mut().find(|(known, _)| *known == help) {
            Some((_, names)) => names.push(name),
            None => all.push((help, vec![name])),
        }
    }
    all.iter().map(|(help, names)| format!("  {}: {help}\n", names.join(", "))).collect()
}

/// A few rates by themselves, and of more the first and the last.
fn of_rates(rates: &Rates) -> String {
    let all: Vec<String> = rates.iter().map(range).collect();
    match all.as_slice() {
        [first, _, _, .., last] if all.len() > 5 => format!("{first}, ..., {last} Hz"),
        all => format!("{} Hz", all.join(", ")),
    }
}

fn range((least, most): (u32, u32)) -> String {
    let (least, most) = (grouped(u64::from(least)), grouped(u64::from(most)));
    if least == most { least } else { format!("{least} to {most}") }
}

/// Numbers of channels: a row of them as its ends.
fn counts(channels: &[u16]) -> String {
    match channels {
        [] => String::new(),
        [one] => one.to_string(),
        [first, .., last] if usize::from(last - first) + 1 == channels.len() => format!("{first} to {last}"),
        several => several.iter().map(u16::to_string).collect::<Vec<_>>().join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::{counts, range};

    #[test]
    fn numbers_of_channels_are_short() {
        assert_eq!(counts(&[2]), "2");
        assert_eq!(counts(&[1, 2, 3, 4]), "1 to 4");
        assert_eq!(counts(&[2, 4, 8]), "2, 4, 8");
        assert_eq!(range((48_000, 48_000)), "48,000");
        assert_eq!(range((44_100, 192_000)), "44,100 to 192,000");
    }
}
