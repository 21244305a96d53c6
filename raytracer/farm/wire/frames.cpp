#include "raytracer/farm/wire/frames.hpp"

#include <gnu/libc-version.h>
#include <sys/utsname.h>
#include <unistd.h>
#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <thread>

#include "common/thread/start_threads.hpp"
#include "common/util/build_id.hpp"
#include "common/util/process.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"

namespace terravox::farm {

const FarmTimes& farm_times() {
    static const FarmTimes times = [] {
        FarmTimes out;
        const char* test = std::getenv("TERRAVOX_FARM_TEST");
        if (test == nullptr || std::string_view(test) != "1")
            return out;
        using std::chrono::milliseconds;
        out.ping = milliseconds(200);
        out.silence = milliseconds(3000);
        out.heartbeat = milliseconds(100);
        out.min_deadline = milliseconds(2000);
        out.redial = milliseconds(200);
        out.max_redial = milliseconds(1000);
        return out;
    }();
    return times;
}

std::chrono::milliseconds RedialPause::next() {
    const std::chrono::milliseconds whole = m_next;
    m_next = std::min(whole * 2, farm_times().max_redial);
    const auto most = static_cast<std::uint32_t>(whole.count() / 4);
    return whole - std::chrono::milliseconds(m_random() % (most + 1));
}

namespace {

std::string features() {
    std::string out;
#if defined(__x86_64__)
    const auto add = [&](const char* name, int has) {
        if (has != 0)
            out += (out.empty() ? "" : " ") + std::string(name);
    };
    add("sse4.2", __builtin_cpu_supports("sse4.2"));
    add("avx2", __builtin_cpu_supports("avx2"));
    add("fma", __builtin_cpu_supports("fma"));
    add("avx512f", __builtin_cpu_supports("avx512f"));
#endif
    return out;
}

/// Aborts a link on which nothing arrives in time. receive() itself has no limit.
class Alarm {
public:
    Alarm(net::Link& link, std::chrono::milliseconds timeout)
        : m_thread(thread::start_thread("the limit of a hello", [this, &link, timeout] {
              std::unique_lock lock(m_mutex);
              if (m_answered.wait_for(lock, timeout, [&] { return m_off; }))
                  return;
              m_rang = true;
              link.abort();
          })) {}
    ~Alarm() { (void)off(); }
    /// @return whether it rang
    bool off() {
        {
            const std::lock_guard lock(m_mutex);
            m_off = true;
        }
        m_answered.notify_all();
        if (m_thread.joinable())
            m_thread.join();
        return m_rang;
    }

private:
    std::mutex m_mutex;
    std::condition_variable m_answered;
    bool m_off = false;
    bool m_rang = false;
    std::thread m_thread;
};

std::string to_name(farm::Role role) {
    switch (role) {
        case farm::COORDINATOR: return "a coordinator";
        case farm::WORKER: return "a worker";
        case farm::OBSERVER: return "an observer";
        default: return "neither coordinator nor worker";
    }
}

/// A peer's text, made safe for one line of a message.
std::string shown(const std::string& text) {
    return util::printable(text.substr(0, 200));
}

/// Whether the role of a certificate permits that of a hello. A peer that queries states and pauses
/// may have a coordinator's role.
bool is_certified_as(const std::string& certified, farm::Role role) {
    if (certified.empty())
        return true;  // with a token, which all peers share
    return (certified == "worker") == (role == farm::WORKER);
}

std::string misfit(const farm::Hello& own, const farm::Hello& other,
                   std::initializer_list<farm::Role> wanted) {
    const auto differ = [](const char* what, const std::string& theirs, const std::string& ours) {
        return std::string(what) + " " + shown(theirs) + "; here: " + ours;
    };
    if (other.protocol() != own.protocol())
        return differ("protocol", std::to_string(other.protocol()), std::to_string(own.protocol()));
    if (std::find(wanted.begin(), wanted.end(), other.role()) == wanted.end())
        return to_name(other.role()) + ", as is this end, or nothing that is of use here";
    if (other.role() == farm::OBSERVER || own.role() == farm::OBSERVER)
        return {};
    if (other.software() != own.software())
        return differ("version", other.software(), own.software());
    if (other.architecture() != own.architecture())
        return differ("processor", other.architecture(), own.architecture());
    if (other.build() != own.build())
        return differ("build", other.build(),
                      own.build() + "; pictures of different builds may differ");
    constexpr std::uint32_t kMax = 1 << 20;
    if (other.role() == farm::WORKER && (other.threads() == 0 || other.threads() > kMax ||
                                         other.capacity() == 0 || other.capacity() > kMax))
        return "a worker of " + std::to_string(other.threads()) + " threads with room for " +
               std::to_string(other.capacity()) + " tiles; allowed: 1 to " + std::to_string(kMax);
    return {};
}

}  // namespace

farm::Hello make_hello(const OwnHello& own) {
    farm::Hello out;
    utsname machine{};
    (void)::uname(&machine);
    out.set_protocol(net::kProtocol);
    out.set_role(own.role);
    out.set_software(std::string("terravox ") + kVersion);
    // The C library counts, too: pictures depend on its tangent.
    out.set_build(std::string(kBuild) + " glibc " + gnu_get_libc_version());
    out.set_architecture(machine.machine);
    out.set_cpu_features(features());
    out.set_name(own.name.empty() ? util::host_name() + ":" + std::to_string(::getpid())
                                  : own.name);
    out.set_threads(static_cast<std::uint32_t>(own.threads));
    out.set_memory_bytes(own.memory_bytes);
    out.set_capacity(static_cast<std::uint32_t>(own.capacity));
    return out;
}

farm::Hello meet(net::Link& link, const farm::Hello& own, std::initializer_list<farm::Role> wanted,
                 std::chrono::milliseconds timeout) {
    const std::string& peer = link.peer();
    Alarm alarm(link, timeout);
    farm::Frame first;
    *first.mutable_hello() = own;
    link.send(std::move(first));
    auto frame = link.receive();
    if (alarm.off())
        throw HelloError(peer, "no answer within " + std::to_string(timeout.count()) + " ms", true);
    if (!frame)
        throw HelloError(
            peer,
            "the link ended" + (link.why_ended().empty() ? "" : " (" + link.why_ended() + ")"),
            true);
    if (frame->has_refusal())
        throw HelloError(peer, "it refuses: " + shown(frame->refusal().reason()),
                         frame->refusal().busy());
    if (!frame->has_hello()) {
        refuse(link, "the first frame was no hello");
        throw HelloError(peer, "its first frame was no hello", false);
    }
    farm::Hello other = std::move(*frame->mutable_hello());
    std::string why = misfit(own, other, wanted);
    if (why.empty() && !is_certified_as(link.certified_role(), other.role()))
        why = to_name(other.role()) + " with the certificate of a " + link.certified_role();
    if (!why.empty()) {
        refuse(link, "refused by " + own.name() + ": " + why);
        throw HelloError(peer, why, false);
    }
    other.set_name(shown(other.name()));
    other.set_cpu_features(shown(other.cpu_features()));
    return other;
}

void refuse(net::Link& link, const std::string& reason, bool busy) noexcept {
    try {
        farm::Frame frame;
        frame.mutable_refusal()->set_reason(reason);
        frame.mutable_refusal()->set_busy(busy);
        link.send(std::move(frame));
        link.close();
    } catch (...) {
        link.abort();
    }
}

}  // namespace terravox::farm
