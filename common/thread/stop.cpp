#include "common/thread/stop.hpp"

#include <semaphore.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <mutex>

#include "common/thread/start_threads.hpp"

namespace terravox::thread {
namespace {

// The state that a signal handler may access: lock-free atomics, and sem_post().
sem_t g_came;
std::array<std::atomic<bool>, NSIG> g_pending{};
static_assert(std::atomic<bool>::is_always_lock_free);

void note(int signal) {
    const int error = errno;
    g_pending[static_cast<std::size_t>(signal)] = true;
    ::sem_post(&g_came);
    errno = error;
}

sigset_t make_set(std::initializer_list<int> signals) noexcept {
    sigset_t out;
    ::sigemptyset(&out);
    for (const int signal : signals)
        ::sigaddset(&out, signal);
    return out;
}

}  // namespace

StopSignals::StopSignals(Options options) : m_on_hangup(std::move(options.on_hangup)) {
    ::sem_init(&g_came, 0, 0);
    for (std::atomic<bool>& pending : g_pending)
        pending = false;
    m_thread = start_thread("signals", [this] { watch(); });
    for (const int signal : options.stop)
        install(signal, options.second_ends_program);
    if (m_on_hangup)
        install(SIGHUP, false);
}

StopSignals::~StopSignals() {
    for (const auto& [signal, before] : m_before)
        ::sigaction(signal, &before, nullptr);
    g_pending[0] = true;  // no signal has this number: ends the thread
    ::sem_post(&g_came);
    m_thread.join();
    ::sem_destroy(&g_came);
}

void StopSignals::install(int signal, bool reset) {
    struct sigaction action{};
    action.sa_handler = note;
    ::sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART | (reset ? static_cast<int>(SA_RESETHAND) : 0);
    struct sigaction before{};
    ::sigaction(signal, &action, &before);
    m_before.emplace_back(signal, before);
}

void StopSignals::watch() noexcept {
    // Whatever signals the other threads of the program block, this one receives them.
    const sigset_t all = make_set({SIGINT, SIGTERM, SIGHUP});
    ::pthread_sigmask(SIG_UNBLOCK, &all, nullptr);
    while (!g_pending[0]) {
        if (::sem_wait(&g_came) != 0)
            continue;
        if (m_on_hangup && g_pending[SIGHUP].exchange(false))
            m_on_hangup();
        const auto is_set = [](const std::atomic<bool>& pending) { return pending.load(); };
        if (std::any_of(g_pending.begin() + 1, g_pending.end(), is_set))
            m_stop.request_stop();
    }
}

SignalsBlocked::SignalsBlocked() {
    const sigset_t both = make_set({SIGINT, SIGTERM});
    ::pthread_sigmask(SIG_BLOCK, &both, &m_before);
}

bool wait_for_stop(const std::stop_token& stop, std::chrono::milliseconds max_wait) {
    std::mutex mutex;
    std::condition_variable_any change;
    std::unique_lock lock(mutex);
    return change.wait_for(lock, stop, max_wait, [&] { return stop.stop_requested(); });
}

}  // namespace terravox::thread
