#include "raytracer/farm/worker/worker_config.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <type_traits>

#include "common/util/command_line.hpp"
#include "common/util/numbers.hpp"
#include "common/util/secret.hpp"
#include "common/util/toml_file.hpp"

namespace terravox::farm {
namespace {

using Addresses = std::vector<sockets::Address>;
using OptionalAddress = std::optional<sockets::Address>;
using Origins = std::vector<remote::HttpOrigin>;

template <class Field>
constexpr bool kIsList = std::is_same_v<Field, Addresses> || std::is_same_v<Field, Origins>;

struct Rule {
    const char* help;
    bool live = false;  ///< may change while the worker runs
    double min = 0;
    double max = 0;
    std::uint16_t port = 0;  ///< default port of an address without one; 0: it must have one
};

/// Calls visit(name, field, rule) for every field, in order; reading, flags and comparison all use
/// this list.
template <class Config, class Visit>
void visit_fields(Config& c, const Visit& visit) {
    constexpr bool kLive = true;
    visit("listen", c.listen,
          Rule{"listen for coordinators that dial (render --worker): [HOST]:PORT; without a host: "
               "all networks",
               false, 0, 0, net::kWorkerPort});
    visit("join", c.join,
          Rule{"coordinator to dial (render --listen), again and again: HOST:PORT; may be given "
               "several times",
               kLive, 0, 0, net::kCoordinatorPort});
    visit("name", c.name, Rule{"what people see it as; default: host and process"});
    visit("threads", c.threads, Rule{"threads of a session; 0: one for each core", kLive, 0, 1024});
    visit("memory_mib", c.memory_mib,
          Rule{"limit for boxes in memory, of all sessions, MiB", kLive, 16, 1 << 20});
    visit("sessions", c.sessions, Rule{"coordinators that it works for at a time", kLive, 1, 64});
    visit("token_file", c.token_file,
          Rule{"file with the token that both ends must know; default: TERRAVOX_FARM_TOKEN of the "
               "environment"});
    visit("tls_ca", c.tls_ca,
          Rule{"certificate of the farm's authority (PEM); with tls_cert and tls_key instead of a "
               "token"});
    visit("tls_cert", c.tls_cert, Rule{"certificate of this machine (PEM)"});
    visit("tls_key", c.tls_key, Rule{"its private key (PEM)"});
    visit("allow_origins", c.allow_origins,
          Rule{"voxel server or web server that coordinators may send it to for boxes: "
               "http(s)://host[:port], of a public address; may be given several times; default: "
               "none, coordinators send them"});
    visit("allow_private_origins", c.allow_private_origins,
          Rule{"the same, of any address: private networks and this machine itself, too"});
    visit(
        "server_origin", c.server_origin,
        Rule{
            "the allowed one that is sent the token of server_token_file: https, or this machine"});
    visit("server_token_file", c.server_token_file,
          Rule{"file with the token of that server, which only its owner may read; no token of the "
               "environment is sent"});
    visit("metrics", c.metrics,
          Rule{"page for Prometheus and health checks: NUMBER:PORT, such as 127.0.0.1:9187; port "
               "0: any "
               "free one, which the log names; default: none"});
    visit("metrics_names", c.metrics_names,
          Rule{"host names of that page, separated by blanks, in addition to localhost, "
               "numbers and this machine's name"});
    visit("drain_s", c.drain_s,
          Rule{"for tiles under way when it has to stop, seconds", kLive, 0, 3600});
    visit("idle_s", c.idle_s,
          Rule{"end when no coordinator has come for so long, seconds; 0: never", kLive, 0, 1e6});
    visit("once", c.once, Rule{"end with the first coordinator"});
    visit("log", c.log, Rule{"trace, debug, info, warn, error or off", kLive});
    visit("log_json", c.log_json, Rule{"log lines as JSON objects, for machines", kLive});
}

std::string to_text(double value) {
    std::string out = std::to_string(value);
    out.erase(out.find_last_not_of('0') + 1);
    if (out.ends_with('.'))
        out.pop_back();
    return out;
}

/// Stores a value of a file, or a text of the command line, in a field.
class Setter {
public:
    Setter(std::string attempt, std::string name, const Rule& rule, std::filesystem::path folder)
        : m_attempt(std::move(attempt)),
          m_name(std::move(name)),
          m_rule(rule),
          m_folder(std::move(folder)) {}

    template <class Field>
    void from_toml(const toml::node& node, Field& field) const {
        if constexpr (std::is_same_v<Field, bool>) {
            if (!node.is_boolean())
                refuse(util::toml_value(node), "true, false");
            field = **node.as_boolean();
        } else if constexpr (std::is_same_v<Field, int> || std::is_same_v<Field, double>) {
            const auto* whole = node.as_integer();
            const auto* number = std::is_same_v<Field, double> ? node.as_floating_point() : nullptr;
            if (whole != nullptr)
                set_number(static_cast<double>(**whole), std::to_string(**whole), field);
            else if (number != nullptr)
                set_number(**number, to_text(**number), field);
            else
                refuse(util::toml_value(node), range<Field>());
        } else if constexpr (kIsList<Field>) {
            const toml::array* list = node.as_array();
            if (list == nullptr)
                refuse(util::toml_value(node), "a list of texts");
            field.clear();
            for (const toml::node& item : *list)
                add(text_in(item), field);
        } else
            set_text(text_in(node), field);
    }
    /// Appends a text to a list; sets any other field.
    template <class Field>
    void from_text(const std::string& text, Field& field) const {
        if constexpr (std::is_same_v<Field, bool>)
            field = text == "yes";
        else if constexpr (std::is_same_v<Field, int> || std::is_same_v<Field, double>) {
            const auto value = util::parse_number<double>(text);
            if (!value || (std::is_same_v<Field, int> && *value != std::floor(*value)))
                refuse("'" + text + "'", range<Field>());
            set_number(*value, text, field);
        } else if constexpr (kIsList<Field>)
            add(text, field);
        else
            set_text(text, field);
    }

private:
    [[noreturn]] void refuse(const std::string& value, const std::string& allowed) const {
        throw util::UsageError(m_attempt + ": " + m_name + " = " + value + "; allowed: " + allowed);
    }
    template <class Field>
    [[nodiscard]] std::string range() const {
        return std::string(std::is_same_v<Field, int> ? "whole numbers, " : "") +
               to_text(m_rule.min) + " to " + to_text(m_rule.max);
    }
    [[nodiscard]] std::string text_in(const toml::node& node) const {
        if (!node.is_string())
            refuse(util::toml_value(node), "a text");
        return **node.as_string();
    }
    template <class Parse>
    auto parsed(const Parse& parse) const {
        try {
            return parse();
        } catch (const util::UsageError& e) {
            throw util::UsageError(m_attempt + ": " + m_name + ": " + e.what());
        }
    }
    [[nodiscard]] sockets::Address address(const std::string& text) const {
        return parsed([&] { return sockets::Address::parse(text, m_rule.port); });
    }
    [[nodiscard]] remote::HttpOrigin origin(const std::string& text) const {
        return parsed([&] { return remote::HttpOrigin::parse(text); });
    }
    void add(const std::string& text, Addresses& field) const { field.push_back(address(text)); }
    void add(const std::string& text, Origins& field) const { field.push_back(origin(text)); }
    template <class Field>
    void set_number(double value, const std::string& text, Field& field) const {
        if (!(value >= m_rule.min && value <= m_rule.max))
            refuse(text, range<Field>());
        field = static_cast<Field>(value);
    }
    void set_text(const std::string& text, OptionalAddress& field) const {
        field.reset();
        if (!text.empty())
            field = address(text);
    }
    void set_text(const std::string& text, std::optional<remote::HttpOrigin>& field) const {
        field.reset();
        if (!text.empty())
            field = origin(text);
    }
    void set_text(const std::string& text, std::filesystem::path& field) const {
        field = text.empty() ? std::filesystem::path() : m_folder / text;
    }
    void set_text(const std::string& text, std::string& field) const {
        constexpr std::size_t kMax = 4096;
        if (text.size() > kMax)
            refuse("a text of " + std::to_string(text.size()) + " bytes",
                   "up to " + std::to_string(kMax));
        for (const char c : text)
            if (static_cast<unsigned char>(c) < ' ' || c == 0x7f)
                refuse("a text with a control character", "one line");
        if (m_name == "log" && text != "trace" && text != "debug" && text != "info" &&
            text != "warn" && text != "error" && text != "off")
            refuse("'" + text + "'", "trace, debug, info, warn, error, off");
        field = text;
    }

    const std::string m_attempt;
    const std::string m_name;
    const Rule& m_rule;
    const std::filesystem::path m_folder;
};

void read_file(const std::filesystem::path& file, WorkerConfig& out) {
    const std::string attempt = "read the worker's configuration " + file.string();
    const auto fail = [&](const std::string& what) {
        throw util::UsageError(attempt + ": " + what);
    };
    const toml::table root = util::read_toml(file, fail);
    const auto* version = root.get("version");
    if (version == nullptr)
        fail("version is missing; allowed: 1");
    else if (version->value_exact<std::int64_t>() != 1)
        fail("version = " + util::toml_value(*version) + "; allowed: 1");
    for (const auto& [key, node] : root) {
        if (key.str() == "version")
            continue;
        bool known = false;
        std::string allowed = "version";
        // Captured by name: clang before 16 captures no structured bindings by itself.
        visit_fields(
            out, [&, &key = key, &node = node](const char* name, auto& field, const Rule& rule) {
                allowed += std::string(", ") + name;
                if (key.str() != name)
                    return;
                known = true;
                Setter(attempt, name, rule, file.parent_path()).from_toml(node, field);
            });
        if (key.str() == "announce")
            fail(
                "the field 'announce' was removed; allowed: coordinators name this worker (render "
                "--worker), or it joins them (join)");
        if (!known)
            fail("unknown field '" + std::string(key.str()) + "'; allowed: " + allowed);
    }
}

void apply_flags(const WorkerArguments& arguments, WorkerConfig& out) {
    std::vector<std::string_view> given;
    for (const auto& [name, text] : arguments.fields)
        visit_fields(
            out, [&, &name = name, &text = text](const char* of, auto& field, const Rule& rule) {
                if (name != of)
                    return;
                // The first of several replaces the values of the file.
                if constexpr (kIsList<std::decay_t<decltype(field)>>)
                    if (std::find(given.begin(), given.end(), name) == given.end())
                        field.clear();
                given.push_back(name);
                Setter("read the command line", name, rule, {}).from_text(text, field);
            });
}

remote::HttpAccess make_http_limits(const WorkerConfig& c) {
    return {std::nullopt, remote::HttpAccess::Limits{c.allow_origins, c.allow_private_origins}};
}

void check_servers(const WorkerConfig& c) {
    const auto fail = [](const std::string& what) {
        throw util::UsageError("start the worker: " + what);
    };
    // A name is checked by the address it resolves to when it is requested; a numeric address is
    // fixed.
    for (const remote::HttpOrigin& o : c.allow_origins)
        if (const auto range = remote::range_of_number(o);
            range && *range != remote::AddressRange::kPublic)
            fail("allow_origins = '" + o.text() +
                 "', no public address; allowed: there public ones, in allow_private_origins "
                 "others");
    for (const remote::HttpOrigin& o : c.allow_private_origins)
        if (remote::range_of_number(o) == remote::AddressRange::kNoMachine)
            fail("allow_private_origins = '" + o.text() +
                 "'; allowed: addresses of single machines");
    if (c.server_origin.has_value() == c.server_token_file.empty())
        fail("only one of server_origin and server_token_file; allowed: both, or neither");
    if (c.server_origin && make_http_limits(c).ranges(*c.server_origin).empty())
        fail("server_origin = '" + c.server_origin->text() +
             "'; allowed: one of allow_origins or allow_private_origins");
}

void check(const WorkerConfig& c) {
    const auto fail = [](const std::string& what) {
        throw util::UsageError("start the worker: " + what);
    };
    if (!c.listen && c.join.empty())
        fail(
            "no coordinator to work for; allowed: listen (--listen :7878), join (--join "
            "HOST:7879)");
    for (const sockets::Address& a : c.join)
        if (a.host.empty() || a.port == 0)
            fail("join = '" + a.text() + "'; allowed: HOST:PORT, port 1 to 65535");
    const int files = !c.tls_ca.empty() + !c.tls_cert.empty() + !c.tls_key.empty();
    if (files != 0 && files != 3)
        fail("only " + std::to_string(files) +
             " of tls_ca, tls_cert, tls_key; allowed: all three, or none");
    if (files == 3 && !c.token_file.empty())
        fail("token_file and tls_ca; allowed: one of them");
    check_servers(c);
}

bool same(const sockets::Address& a, const sockets::Address& b) {
    return a.host == b.host && a.port == b.port;
}
bool same(const OptionalAddress& a, const OptionalAddress& b) {
    return a.has_value() == b.has_value() && (!a || same(*a, *b));
}
bool same(const Addresses& a, const Addresses& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const auto& x, const auto& y) { return same(x, y); });
}
template <class Field>
bool same(const Field& a, const Field& b) {
    return a == b;
}

/// visit(name, field of a, field of b, rule).
template <class A, class Visit>
void visit_both(A& a, const WorkerConfig& b, const Visit& visit) {
    visit_fields(a, [&](std::string_view name, auto& field, const Rule& rule) {
        visit_fields(b, [&](std::string_view other, const auto& its, const Rule&) {
            if constexpr (std::is_same_v<std::decay_t<decltype(field)>,
                                         std::decay_t<decltype(its)>>)
                if (name == other)
                    visit(name, field, its, rule);
        });
    });
}

}  // namespace

void add_worker_options(CLI::App& app, WorkerArguments& arguments) {
    app.add_option(
        "--config", arguments.file,
        "file with all this (config/worker.toml); flags override it; SIGHUP reads it again");
    util::refuse_removed_option(app, "--announce",
                                "coordinators name this worker (render --worker), or it joins them "
                                "(--join)");
    WorkerConfig defaults;
    visit_fields(defaults, [&](const char* name, auto& field, const Rule& rule) {
        using Field = std::decay_t<decltype(field)>;
        std::string flag = std::string("--") + name;
        std::replace(flag.begin(), flag.end(), '_', '-');
        const auto keep = [&arguments, of = std::string(name)](const std::string& text) {
            arguments.fields.emplace_back(of, text);
        };
        if constexpr (std::is_same_v<Field, bool>)
            app.add_flag_callback(flag, [keep] { keep("yes"); }, rule.help);
        else if constexpr (kIsList<Field>)
            app.add_option_function<std::vector<std::string>>(
                   flag,
                   [keep](const std::vector<std::string>& texts) {
                       for (const auto& t : texts)
                           keep(t);
                   },
                   rule.help)
                ->expected(1)
                ->take_all()
                ->allow_extra_args(false);
        else {
            auto* option = app.add_option_function<std::string>(flag, keep, rule.help);
            if constexpr (std::is_same_v<Field, int> || std::is_same_v<Field, double>)
                option->default_str(to_text(field))->type_name("NUMBER");
        }
    });
}

WorkerConfig load_worker_config(const WorkerArguments& arguments) {
    WorkerConfig out;
    if (!arguments.file.empty())
        read_file(arguments.file, out);
    apply_flags(arguments, out);
    check(out);
    return out;
}

net::Credentials make_credentials(const WorkerConfig& config) {
    net::Credentials out;
    out.ca = config.tls_ca;
    out.certificate = config.tls_cert;
    out.key = config.tls_key;
    if (out.tls())
        return out;
    out.token = util::find_token(config.token_file, util::kFarmTokenVariable);
    if (out.token.empty())
        throw util::UsageError(
            "start the worker: neither token nor certificates; allowed: token_file, "
            "TERRAVOX_FARM_TOKEN, or tls_ca with tls_cert and tls_key");
    return out;
}

remote::HttpAccess make_http_access(const WorkerConfig& config) {
    remote::HttpAccess out = make_http_limits(config);
    if (config.server_origin)
        out.token.emplace(*config.server_origin,
                          util::find_token(config.server_token_file, util::kServerTokenVariable));
    return out;
}

WorkerConfigChange difference(const WorkerConfig& running, const WorkerConfig& wanted) {
    WorkerConfigChange out;
    visit_both(running, wanted,
               [&](std::string_view name, const auto& a, const auto& b, const Rule& rule) {
                   if (!same(a, b))
                       (rule.live ? out.now : out.restart).emplace_back(name);
               });
    return out;
}

WorkerConfig reloaded(const WorkerConfig& running, const WorkerConfig& wanted) {
    WorkerConfig out = running;
    visit_both(out, wanted, [](std::string_view, auto& a, const auto& b, const Rule& rule) {
        if (rule.live)
            a = b;
    });
    return out;
}

}  // namespace terravox::farm
