#include "raytracer/farm/net/discovery.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <thread>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/farm/net/said.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using terravox::test::eventually;

namespace {

/// A program in the background that ends with its owner, and with this process.
class Child {
public:
    Child(const std::string& command, const std::string& log) : m_pid(fork()) {
        if (m_pid != 0)
            return;
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        const std::string whole = "exec >>'" + log + "' 2>&1; exec " + command;
        execl("/bin/sh", "sh", "-c", whole.c_str(), nullptr);
        _exit(127);
    }
    ~Child() {
        kill(m_pid, SIGTERM);
        waitpid(m_pid, nullptr, 0);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

private:
    pid_t m_pid;
};

/// A system bus and an Avahi daemon of this process' own. The daemon is alone in a network with
/// nothing but a loopback: neither hears what is on the real one, nor says anything there. D-Bus
/// looks the bus's address up once in a process, so all tests have the same.
class Network {
public:
    Network() {
        m_path = m_folder.path().string();
        setenv("DBUS_SYSTEM_BUS_ADDRESS", ("unix:path=" + m_path + "/bus").c_str(), 1);
        std::ofstream(m_path + "/bus.conf")
            << "<!DOCTYPE busconfig PUBLIC \"-//freedesktop//DTD D-BUS Bus Configuration 1.0//EN\" "
               "\"http://www.freedesktop.org/standards/dbus/1.0/"
               "busconfig.dtd\">\n<busconfig><listen>unix:path="
            << m_path
            << "/bus</listen><auth>EXTERNAL</auth><policy context=\"default\"><allow "
               "user=\"*\"/><allow own=\"*\"/>"
               "<allow send_destination=\"*\"/><allow "
               "receive_sender=\"*\"/></policy></busconfig>\n";
        std::ofstream(m_path + "/avahi.conf")
            << "[server]\nhost-name=farmtest\nuse-ipv4=yes\nuse-ipv6=no\nallow-interfaces=lo\n"
               "[wide-area]\nenable-wide-area=no\n[publish]\npublish-hinfo=no\npublish-workstation="
               "no\n";
    }
    static Network& get() {
        static Network network;
        return network;
    }

    /// Why the daemon cannot be tried on this machine; empty: it can.
    [[nodiscard]] static std::string missing() {
        if (getuid() != 0)
            return "wants root, for a network of its own";
        for (const char* program : {"dbus-daemon", "avahi-daemon", "unshare", "ip"})
            if (std::system(("PATH=$PATH:/usr/sbin:/sbin command -v " + std::string(program) +
                             " >/dev/null")
                                .c_str()) != 0)
                return std::string("wants ") + program;
        if (std::system("unshare -m -n true 2>/dev/null") != 0)
            return "may not make a network of its own";
        return {};
    }
    void start_bus() {
        m_bus.emplace("dbus-daemon --config-file='" + m_path + "/bus.conf' --nofork --nopidfile",
                      m_path + "/log");
        REQUIRE(eventually([&] { return access((m_path + "/bus").c_str(), F_OK) == 0; }));
    }
    void start_avahi() {
        m_avahi.emplace(
            "unshare -m -n sh -c 'PATH=$PATH:/usr/sbin:/sbin; ip link set lo up && mkdir -p "
            "/run/avahi-daemon && mount -t tmpfs none /run/avahi-daemon && "
            "exec avahi-daemon -f " +
                m_path + "/avahi.conf --no-drop-root --no-chroot --no-rlimits --no-proc-title'",
            m_path + "/log");
    }
    void stop_avahi() { m_avahi.reset(); }
    void stop() {
        m_avahi.reset();
        m_bus.reset();
        unlink((m_path + "/bus").c_str());
    }
    [[nodiscard]] std::string log() const {
        std::ostringstream out;
        out << std::ifstream(m_path + "/log").rdbuf();
        return out.str();
    }

private:
    test::TemporaryFolder m_folder;
    std::string m_path;
    std::optional<Child> m_bus, m_avahi;
};

bool avahi_runs() {
    try {
        return net::discover("worker", 1ms).empty();
    } catch (const net::NoDiscoveryError&) {
        return false;
    }
}

struct Running {
    Running() {
        Network::get().start_bus();
        Network::get().start_avahi();
        REQUIRE(eventually(avahi_runs));
    }
    ~Running() { Network::get().stop(); }
};

/// The events of a browser, to be read from another thread.
class RecordedEvents {
public:
    [[nodiscard]] net::ServiceBrowser::OnEvent listener() {
        return [this](net::ServiceBrowser::Event event, const net::FoundService& service) {
            const std::lock_guard lock(m_mutex);
            if (event == net::ServiceBrowser::Event::kFound) {
                ++m_found;
                m_now[service.name] = service;
            } else
                m_strays += m_now.erase(service.name) == 0;
        };
    }
    [[nodiscard]] std::map<std::string, net::FoundService> now() const {
        const std::lock_guard lock(m_mutex);
        return m_now;
    }
    /// Services that were reported as gone without having been found.
    [[nodiscard]] int strays() const {
        const std::lock_guard lock(m_mutex);
        return m_strays;
    }
    [[nodiscard]] int found() const {
        const std::lock_guard lock(m_mutex);
        return m_found;
    }

private:
    mutable std::mutex m_mutex;
    std::map<std::string, net::FoundService> m_now;
    int m_found = 0, m_strays = 0;
};

#define NEED_A_NETWORK()                                                    \
    if (const std::string missing = Network::missing(); !missing.empty()) { \
        WARN("not tried: " << missing);                                     \
        return;                                                             \
    }

}  // namespace

TEST_CASE("without a bus an announcement is a warning, and a search an error",
          "[common][net][discovery]") {
    (void)Network::get();
    const test::Said log;
    {
        const net::Announcement announced("worker", 7878, {{"protocol", "1"}});
        CHECK(announced.name().empty());
    }
    INFO(log.all());
    CHECK(log.warnings() == 1);
    CHECK_THAT(log.all(), test::contains("announce"));
    CHECK_THROWS_AS(net::discover("worker", 1s), net::NoDiscoveryError);
    CHECK_THROWS_WITH(
        net::discover("worker", 1s),
        test::contains("look for a worker on the network") && test::contains("name the addresses"));
}

TEST_CASE("a text that does not fit is refused", "[common][net][discovery]") {
    (void)Network::get();
    CHECK_THROWS_WITH(net::Announcement("worker", 7878, {{"build", std::string(300, 'x')}}),
                      test::contains("build has 300 bytes; allowed: 200"));
}

TEST_CASE("an announced service is found, with all its data, until it ends",
          "[common][net][discovery]") {
    NEED_A_NETWORK();
    const Running running;
    const test::Said log;
    RecordedEvents events;
    auto announced = std::make_unique<net::Announcement>(
        "worker", 7878,
        net::ServiceText{{"protocol", "1"}, {"software", "terravox 0.1.0"}, {"build", "a=b"}});
    const net::Announcement coordinator("coordinator", 7879, {});
    REQUIRE(eventually([&] { return !announced->name().empty() && !coordinator.name().empty(); }));
    const net::ServiceBrowser browser("worker", events.listener());
    REQUIRE(eventually([&] { return events.now().size() == 1; }));
    const auto service = events.now().begin()->second;
    CHECK(service.name == announced->name());
    CHECK(service.address == "127.0.0.1");
    CHECK(service.port == 7878);
    CHECK(service.text == net::ServiceText{{"protocol", "1"},
                                           {"software", "terravox 0.1.0"},
                                           {"build", "a=b"},
                                           {"role", "worker"}});
    CHECK(net::discover("worker", test::kHangs) == std::vector{service});
    CHECK(net::discover("coordinator", test::kHangs).size() == 1);
    CHECK(net::discover("observer", test::kHangs).empty());
    announced.reset();
    CHECK(eventually([&] { return events.now().empty(); }));
    CHECK(events.strays() == 0);
    INFO(log.all() << Network::get().log());
    CHECK(log.warnings() == 0);
}

TEST_CASE("services of one name get numbers, and each is found", "[common][net][discovery]") {
    NEED_A_NETWORK();
    const Running running;
    std::vector<std::unique_ptr<net::Announcement>> announced;
    for (int i = 0; i < 3; ++i)
        announced.push_back(std::make_unique<net::Announcement>(
            "worker", std::uint16_t{7000}, net::ServiceText{{"n", std::to_string(i)}}));
    REQUIRE(eventually([&] {
        return std::none_of(announced.begin(), announced.end(),
                            [](const auto& a) { return a->name().empty(); });
    }));
    std::set<std::string> names, numbers;
    for (const auto& service : net::discover("worker", test::kHangs)) {
        names.insert(service.name);
        numbers.insert(service.text.at("n"));
    }
    CHECK(names.size() == 3);
    CHECK(numbers == std::set<std::string>{"0", "1", "2"});
}

TEST_CASE("a bus that starts late, or is restarted, is used", "[common][net][discovery]") {
    NEED_A_NETWORK();
    Network& network = Network::get();
    const test::Said log;
    const net::Announcement announced("worker", 7878, {});
    CHECK(log.warnings() == 1);
    {
        const Running running;
        CHECK(eventually([&] { return !announced.name().empty(); }));

        RecordedEvents events;
        const net::ServiceBrowser browser("worker", events.listener());
        REQUIRE(eventually([&] { return events.now().size() == 1; }));
        network.stop();
        CHECK(eventually([&] { return events.now().empty() && announced.name().empty(); }));
        network.start_bus();
        network.start_avahi();
        CHECK(eventually([&] { return events.now().size() == 1 && !announced.name().empty(); }));
        CHECK(events.strays() == 0);
        INFO(log.all());
        CHECK(log.warnings() == 3);
    }
}

TEST_CASE("a daemon that starts late, or is restarted, is used", "[common][net][discovery]") {
    NEED_A_NETWORK();
    Network& network = Network::get();
    network.start_bus();
    const test::Said log;
    {
        const net::Announcement announced("worker", 7878, {});
        REQUIRE(eventually([&] { return log.warnings() == 1; }));
        CHECK_THROWS_AS(net::discover("worker", 1s), net::NoDiscoveryError);
        network.start_avahi();
        REQUIRE(eventually([&] { return !announced.name().empty(); }));

        RecordedEvents events;
        const net::ServiceBrowser browser("worker", events.listener());
        REQUIRE(eventually([&] { return events.now().size() == 1; }));
        network.stop_avahi();
        CHECK(eventually([&] { return events.now().empty() && announced.name().empty(); }));
        network.start_avahi();
        CHECK(eventually([&] { return events.now().size() == 1 && !announced.name().empty(); }));
        CHECK(events.found() == 2);
        CHECK(events.strays() == 0);
        network.stop();
        CHECK(eventually([&] { return events.now().empty() && announced.name().empty(); }));
    }
    INFO(log.all());
    CHECK(log.warnings() >= 3);
}
