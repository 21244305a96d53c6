#include "raytracer/farm/net/discovery.hpp"

#include <mutex>

#include "common/util/log.hpp"
#include "common/util/printable.hpp"

#ifdef TERRAVOX_AVAHI
#include <avahi-client/client.h>
#include <avahi-client/lookup.h>
#include <avahi-client/publish.h>
#include <avahi-common/alternative.h>
#include <avahi-common/domain.h>
#include <avahi-common/error.h>
#include <avahi-common/malloc.h>
#include <avahi-common/thread-watch.h>
#include <avahi-common/timeval.h>
#include <net/if.h>
#include <unistd.h>

#include <array>
#include <condition_variable>
#include <optional>
#include <tuple>
#include <utility>
#endif

namespace terravox::net {
#ifdef TERRAVOX_AVAHI
namespace {

constexpr std::size_t kMaxInstances = 1000;  // Avahi's daemon gives a client 1024 objects
constexpr unsigned kRetry_ms = 2000;         ///< between attempts to reach a bus or a daemon
// A daemon that restarts is soon there again; one that drops every client must not keep a core
// busy.
constexpr unsigned kReconnect_ms = 100;

struct FreePoll {
    void operator()(AvahiThreadedPoll* poll) const noexcept { avahi_threaded_poll_free(poll); }
};
struct FreeTexts {
    void operator()(AvahiStringList* list) const noexcept { avahi_string_list_free(list); }
};
using TextList = std::unique_ptr<AvahiStringList, FreeTexts>;

/// A connection to Avahi's daemon with a thread of its own, renewed whenever it fails, until the
/// daemon or the system bus has come back. All work of derived classes happens on that thread, with
/// the poll's lock held, or before it starts or after it ends: no other lock is needed.
class Client {
public:
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

protected:
    Client() = default;
    virtual ~Client() { end(); }
    /// @param patient whether to wait for a daemon, or a bus, that is not running yet
    /// @return 0, or Avahi's error code
    [[nodiscard]] int begin(bool patient) {
        m_poll.reset(avahi_threaded_poll_new());
        if (!m_poll)
            return AVAHI_ERR_NO_MEMORY;
        if (patient)
            renew();
        else if (const int error = connect(false); error != 0)
            return error;
        return avahi_threaded_poll_start(m_poll.get()) == 0 ? 0 : AVAHI_ERR_FAILURE;
    }
    /// To be called first by the destructors of derived classes: no call reaches them afterwards.
    void end() noexcept {
        if (!m_poll)
            return;
        avahi_threaded_poll_stop(m_poll.get());
        if (m_client != nullptr)
            avahi_client_free(m_client);
        m_client = nullptr;
        m_poll.reset();
    }

    /// The daemon is available: may be called again.
    virtual void running(AvahiClient* client) = 0;
    virtual void lost() = 0;   ///< called when everything made with the client is invalid
    virtual void renamed() {}  ///< the machine's name is being changed: running() follows
    virtual void absent(const char* why) = 0;  ///< the daemon is not available

private:
    /// Gives up the connection, if there is one, and makes another: now, or later if it fails. Not
    /// to be called from within the library, which may still use what is given up.
    void renew() {
        if (m_client != nullptr) {
            lost();
            avahi_client_free(m_client);
            m_client = nullptr;
        }
        const int error = connect(true);
        if (error == 0)
            return;
        absent(avahi_strerror(error));
        renew_in(kRetry_ms);
    }
    void renew_in(unsigned delay_ms) {
        const AvahiPoll* poll = avahi_threaded_poll_get(m_poll.get());
        timeval when{};
        avahi_elapse_time(&when, delay_ms, 0);
        if (m_timeout == nullptr)
            m_timeout = poll->timeout_new(poll, &when, on_timeout, this);
        else
            poll->timeout_update(m_timeout, &when);
    }
    static void on_timeout(AvahiTimeout* timeout, void* me) noexcept {
        Client& self = *static_cast<Client*>(me);
        // One that is not set back would be called without end.
        avahi_threaded_poll_get(self.m_poll.get())->timeout_update(timeout, nullptr);
        try {
            self.renew();
        } catch (const std::exception& e) {
            util::log_error("speak with Avahi: {}", e.what());
        }
    }

    /// @return 0, or Avahi's error code; there is no client then
    [[nodiscard]] int connect(bool patient) {
        int error = 0;
        m_client = avahi_client_new(avahi_threaded_poll_get(m_poll.get()),
                                    patient ? AVAHI_CLIENT_NO_FAIL : AvahiClientFlags(0), on_state,
                                    this, &error);
        if (m_client == nullptr)
            return error;
        if (avahi_client_get_state(m_client) != AVAHI_CLIENT_FAILURE)
            return 0;
        error = avahi_client_errno(m_client);
        lost();
        avahi_client_free(m_client);
        m_client = nullptr;
        return error;
    }

    // Called from within avahi_client_new, too, before that has returned the client.
    static void on_state(AvahiClient* client, AvahiClientState state, void* me) noexcept {
        try {
            static_cast<Client*>(me)->on_state(client, state);
        } catch (const std::exception& e) {
            util::log_error("speak with Avahi: {}", e.what());
        }
    }
    void on_state(AvahiClient* client, AvahiClientState state) {
        switch (state) {
            case AVAHI_CLIENT_S_RUNNING: running(client); break;
            case AVAHI_CLIENT_S_REGISTERING:
            case AVAHI_CLIENT_S_COLLISION: renamed(); break;
            case AVAHI_CLIENT_CONNECTING: absent("its daemon does not run"); break;
            case AVAHI_CLIENT_FAILURE:
                // One that fails while it is made is connect()'s.
                if (client == m_client)
                    failed(avahi_client_errno(client));
                break;
        }
    }
    void failed(int error) {
        if (error == AVAHI_ERR_DISCONNECTED)
            return renew_in(kReconnect_ms);
        absent(avahi_strerror(error));
        renew_in(kRetry_ms);
    }

    std::unique_ptr<AvahiThreadedPoll, FreePoll> m_poll;
    AvahiClient* m_client = nullptr;
    AvahiTimeout* m_timeout = nullptr;  ///< the poll's own
};

std::string host_name() {
    std::array<char, 256> name{};
    if (gethostname(name.data(), name.size() - 1) != 0)
        return "host";
    const std::string whole(name.data());
    return whole.substr(0, whole.find('.'));
}

// A label of DNS is limited: the distinguishing part, role and port, must fit in it.
std::string service_name(const std::string& role, std::uint16_t port) {
    constexpr std::size_t kMax_bytes = AVAHI_LABEL_MAX - 1;
    constexpr std::size_t kRoomForNumber = 5;
    const std::string end = " " + std::to_string(port);
    return (role + " " + host_name()).substr(0, kMax_bytes - kRoomForNumber - end.size()) + end;
}

}  // namespace

class Announcement::Impl final : private Client {
public:
    Impl(const std::string& role, std::uint16_t port, ServiceText text)
        : m_port(port), m_wanted_name(service_name(role, port)) {
        text["role"] = role;
        for (const auto& [key, value] : text) {
            if (key.size() + value.size() > kMaxServiceText_bytes)
                throw util::Error(
                    "announce the " + role + ": " + key + " has " + std::to_string(value.size()) +
                    " bytes; allowed: " + std::to_string(kMaxServiceText_bytes) + " with its name");
            m_text.reset(avahi_string_list_add_pair(m_text.release(), key.c_str(), value.c_str()));
        }
        if (const int error = begin(true); error != 0)
            absent(avahi_strerror(error));
    }
    ~Impl() override { end(); }
    [[nodiscard]] std::string name() const {
        const std::lock_guard lock(m_name_mutex);
        return m_name;
    }

private:
    void running(AvahiClient* client) override {
        m_warned = false;
        if (m_group == nullptr)
            m_group = avahi_entry_group_new(client, on_group, this);
        if (m_group == nullptr)
            return absent(avahi_strerror(avahi_client_errno(client)));
        if (avahi_entry_group_is_empty(m_group) != 0)
            publish();
    }
    void renamed() override {
        if (m_group != nullptr)
            avahi_entry_group_reset(m_group);
        set_name({});
    }
    void lost() override {
        m_group = nullptr;
        set_name({});
    }
    void absent(const char* why) override {
        if (!m_warned)
            util::log_warn("announce '{}' on the network: Avahi: {}", m_wanted_name, why);
        m_warned = true;
    }

    void publish() {
        int error = 0;
        while ((error = avahi_entry_group_add_service_strlst(
                    m_group, AVAHI_IF_UNSPEC, AVAHI_PROTO_UNSPEC, AvahiPublishFlags(0),
                    m_wanted_name.c_str(), kServiceType, nullptr, nullptr, m_port, m_text.get())) ==
               AVAHI_ERR_COLLISION)
            choose_another();
        if (error == 0)
            error = avahi_entry_group_commit(m_group);
        if (error != 0)
            absent(avahi_strerror(error));
    }
    void choose_another() {
        char* other = avahi_alternative_service_name(m_wanted_name.c_str());
        m_wanted_name = other;
        avahi_free(other);
    }
    void set_name(const std::string& name) {
        const std::lock_guard lock(m_name_mutex);
        m_name = name;
    }

    static void on_group(AvahiEntryGroup* group, AvahiEntryGroupState state, void* me) noexcept {
        try {
            static_cast<Impl*>(me)->on_group(group, state);
        } catch (const std::exception& e) {
            util::log_error("announce a service: {}", e.what());
        }
    }
    // Called from within avahi_entry_group_new, too.
    void on_group(AvahiEntryGroup* group, AvahiEntryGroupState state) {
        m_group = group;
        if (state == AVAHI_ENTRY_GROUP_ESTABLISHED) {
            set_name(m_wanted_name);
            util::log_info("announced on the network as '{}'", m_wanted_name);
        } else if (state == AVAHI_ENTRY_GROUP_COLLISION) {
            choose_another();
            publish();
        } else if (state == AVAHI_ENTRY_GROUP_FAILURE)
            absent(avahi_strerror(avahi_client_errno(avahi_entry_group_get_client(group))));
    }

    const std::uint16_t m_port;
    std::string m_wanted_name;
    TextList m_text;
    AvahiEntryGroup* m_group = nullptr;
    bool m_warned = false;
    /// Guards the name alone, so that reading it never waits for the daemon.
    mutable std::mutex m_name_mutex;
    std::string m_name;
};

/// A service appears once for each network and kind of address (an instance), each resolved
/// separately and watched from then on. What is reported is the service: found with the best
/// address of its instances, gone with the last of them.
///
/// The instances belong to the client's thread. m_mutex guards what settle() waits for: that the
/// daemon has reported all it knows, and that each instance has been resolved or has failed.
class ServiceBrowser::Impl final : private Client {
public:
    Impl(std::string role, OnEvent on_event)
        : m_role(std::move(role)), m_on_event(std::move(on_event)) {
        if (const int error = begin(false); error != 0)
            throw NoDiscoveryError("look for a " + m_role +
                                   " on the network: Avahi is not there: " + avahi_strerror(error) +
                                   "; start avahi-daemon, or name the addresses");
    }
    ~Impl() override { end(); }

    void settle(std::chrono::milliseconds timeout) {
        std::unique_lock lock(m_mutex);
        m_settled.wait_for(lock, timeout, [&] { return m_told_all && m_unresolved == 0; });
    }

private:
    struct Instance {
        Impl* owner = nullptr;
        std::string name;
        AvahiServiceResolver* resolver = nullptr;
        bool answered = false;
        int rank = 0;  ///< of the address: lower is better
        std::optional<FoundService> found;
    };
    using Key = std::tuple<std::string, AvahiIfIndex, AvahiProtocol>;

    void running(AvahiClient* client) override {
        m_warned = false;
        if (m_browser != nullptr)
            return;
        m_browser =
            avahi_service_browser_new(client, AVAHI_IF_UNSPEC, AVAHI_PROTO_UNSPEC, kServiceType,
                                      nullptr, AvahiLookupFlags(0), on_browser, this);
        if (m_browser == nullptr)
            absent(avahi_strerror(avahi_client_errno(client)));
    }
    void lost() override {
        m_browser = nullptr;
        m_instances.clear();
        {
            const std::lock_guard lock(m_mutex);
            m_told_all = false;
            m_unresolved = 0;
        }
        const auto reported = std::move(m_reported);
        m_reported.clear();
        for (const auto& [name, service] : reported)
            m_on_event(Event::kGone, service);
    }
    void absent(const char* why) override {
        if (!m_warned)
            util::log_warn("look for a {} on the network: Avahi: {}", m_role, why);
        m_warned = true;
    }

    static void on_browser(AvahiServiceBrowser* browser, AvahiIfIndex interface,
                           AvahiProtocol protocol, AvahiBrowserEvent event, const char* name,
                           const char* type, const char* domain, AvahiLookupResultFlags /*flags*/,
                           void* me) noexcept {
        try {
            Impl& self = *static_cast<Impl*>(me);
            if (event == AVAHI_BROWSER_NEW)
                self.add({name, interface, protocol}, avahi_service_browser_get_client(browser),
                         type, domain);
            else if (event == AVAHI_BROWSER_REMOVE)
                self.remove({name, interface, protocol});
            else if (event == AVAHI_BROWSER_ALL_FOR_NOW)
                self.note_all_told();
            else if (event == AVAHI_BROWSER_FAILURE)
                self.absent(
                    avahi_strerror(avahi_client_errno(avahi_service_browser_get_client(browser))));
        } catch (const std::exception& e) {
            util::log_error("look for services: {}", e.what());
        }
    }

    void add(const Key& key, AvahiClient* client, const char* type, const char* domain) {
        const auto& [name, interface, protocol] = key;
        if (m_instances.contains(key))
            return;
        if (m_instances.size() >= kMaxInstances) {
            if (!m_too_many)
                util::log_warn(
                    "look for a {} on the network: more than {} services; the others are left out",
                    m_role, kMaxInstances);
            m_too_many = true;
            return;
        }
        Instance& instance = m_instances[key];
        instance.owner = this;
        instance.name = name;
        {
            const std::lock_guard lock(m_mutex);
            ++m_unresolved;
        }
        // The resolver stays, since it also reports later changes.
        instance.resolver =
            avahi_service_resolver_new(client, interface, protocol, name.c_str(), type, domain,
                                       protocol, AvahiLookupFlags(0), on_resolver, &instance);
        if (instance.resolver == nullptr) {
            util::log_warn("look up the service '{}': {}", util::printable(name),
                           avahi_strerror(avahi_client_errno(client)));
            note_answer(instance);
        }
    }
    void remove(const Key& key) {
        const auto found = m_instances.find(key);
        if (found == m_instances.end())
            return;
        note_answer(found->second);
        if (found->second.resolver != nullptr)
            avahi_service_resolver_free(found->second.resolver);
        m_instances.erase(found);
        report(std::get<0>(key));
    }

    static void on_resolver(AvahiServiceResolver* /*resolver*/, AvahiIfIndex interface,
                            AvahiProtocol /*protocol*/, AvahiResolverEvent event, const char* name,
                            const char* /*type*/, const char* /*domain*/, const char* /*host*/,
                            const AvahiAddress* address, std::uint16_t port, AvahiStringList* text,
                            AvahiLookupResultFlags /*flags*/, void* data) noexcept {
        Instance& instance = *static_cast<Instance*>(data);
        Impl& self = *instance.owner;
        try {
            if (event == AVAHI_RESOLVER_FOUND)
                self.set_found(instance, interface, *address, port, text);
            else {
                util::log_debug("look up the service '{}': no answer", util::printable(name));
                instance.found.reset();
            }
            self.report(instance.name);
        } catch (const std::exception& e) {
            util::log_error("look up a service: {}", e.what());
        }
        self.note_answer(instance);
    }

    static void set_found(Instance& instance, AvahiIfIndex interface, const AvahiAddress& address,
                          std::uint16_t port, AvahiStringList* text) {
        FoundService service;
        service.name = util::printable(instance.name);
        service.port = port;
        std::array<char, AVAHI_ADDRESS_STR_MAX> number{};
        avahi_address_snprint(number.data(), number.size(), &address);
        service.address = number.data();
        instance.rank = address.proto == AVAHI_PROTO_INET ? 0 : 1;
        const auto& v6 = address.data.ipv6.address;
        if (address.proto == AVAHI_PROTO_INET6 && v6[0] == 0xfe && (v6[1] & 0xc0) == 0x80) {
            instance.rank = 2;
            std::array<char, IF_NAMESIZE> link{};
            if (if_indextoname(static_cast<unsigned>(interface), link.data()) != nullptr)
                service.address += std::string("%") + link.data();
            else
                service.address += "%" + std::to_string(interface);
        }
        for (AvahiStringList* entry = text; entry != nullptr;
             entry = avahi_string_list_get_next(entry)) {
            char *key = nullptr, *value = nullptr;
            std::size_t size = 0;
            if (avahi_string_list_get_pair(entry, &key, &value, &size) != 0)
                continue;
            service.text[util::printable(key)] =
                util::printable(value != nullptr ? std::string(value, size) : std::string());
            avahi_free(key);
            avahi_free(value);
        }
        instance.found = std::move(service);
    }

    /// Reports the state of a name if it differs from the last report.
    void report(const std::string& name) {
        const Instance* best = nullptr;
        for (auto it = m_instances.lower_bound({name, 0, 0});
             it != m_instances.end() && std::get<0>(it->first) == name; ++it) {
            const Instance& instance = it->second;
            if (!instance.found)
                continue;
            const auto role = instance.found->text.find("role");
            if (role == instance.found->text.end() || role->second != m_role)
                continue;
            if (best == nullptr || instance.rank < best->rank)
                best = &instance;
        }
        const auto reported = m_reported.find(name);
        if (best == nullptr) {
            if (reported == m_reported.end())
                return;
            const FoundService gone = std::move(reported->second);
            m_reported.erase(reported);
            m_on_event(Event::kGone, gone);
        } else if (reported == m_reported.end() || reported->second != *best->found) {
            const FoundService found = m_reported[name] = *best->found;
            m_on_event(Event::kFound, found);
        }
    }

    void note_answer(Instance& instance) {
        if (std::exchange(instance.answered, true))
            return;
        const std::lock_guard lock(m_mutex);
        --m_unresolved;
        m_settled.notify_all();
    }
    void note_all_told() {
        const std::lock_guard lock(m_mutex);
        m_told_all = true;
        m_settled.notify_all();
    }

    const std::string m_role;
    const OnEvent m_on_event;
    AvahiServiceBrowser* m_browser = nullptr;
    std::map<Key, Instance> m_instances;
    std::map<std::string, FoundService> m_reported;
    bool m_warned = false;
    bool m_too_many = false;
    std::mutex m_mutex;
    std::condition_variable m_settled;
    bool m_told_all = false;
    std::size_t m_unresolved = 0;
};

#else

namespace {

constexpr const char* kWithout = "this program was built without Avahi (libavahi-client-dev)";

}  // namespace

class Announcement::Impl {
public:
    Impl(const std::string& role, std::uint16_t /*port*/, const ServiceText& /*text*/) {
        util::log_warn("announce the {} on the network: {}", role, kWithout);
    }
    [[nodiscard]] static std::string name() { return {}; }
};

class ServiceBrowser::Impl {
public:
    Impl(const std::string& role, const OnEvent& /*on_event*/) {
        throw NoDiscoveryError("look for a " + role + " on the network: " + kWithout +
                               "; name the addresses");
    }
    static void settle(std::chrono::milliseconds /*timeout*/) {}
};

#endif

Announcement::Announcement(const std::string& role, std::uint16_t port, const ServiceText& text)
    : m_impl(std::make_unique<Impl>(role, port, text)) {}
Announcement::~Announcement() = default;
std::string Announcement::name() const {
    return m_impl->name();
}

ServiceBrowser::ServiceBrowser(const std::string& role, OnEvent on_event)
    : m_impl(std::make_unique<Impl>(role, std::move(on_event))) {}
ServiceBrowser::~ServiceBrowser() = default;
void ServiceBrowser::settle(std::chrono::milliseconds timeout) {
    m_impl->settle(timeout);
}

std::vector<FoundService> discover(const std::string& role, std::chrono::milliseconds timeout) {
    std::mutex mutex;
    std::map<std::string, FoundService> found;
    {
        ServiceBrowser browser(role, [&](ServiceBrowser::Event event, const FoundService& service) {
            const std::lock_guard lock(mutex);
            if (event == ServiceBrowser::Event::kFound)
                found[service.name] = service;
            else
                found.erase(service.name);
        });
        browser.settle(timeout);
    }
    std::vector<FoundService> out;
    for (auto& [name, service] : found)
        out.push_back(std::move(service));
    return out;
}

}  // namespace terravox::net
