#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace terravox::thread {

/// Describes to the thread sanitizer an order between threads that a library establishes by means
/// the sanitizer does not see: Debian's oneTBB is compiled without it, so what one task hands to
/// another would be reported as a race. It orders nothing itself, and does nothing in other builds.
class TsanOrder {
public:
    /// What this thread has done so far precedes what threads do after a later follow().
    void precede() noexcept {
#if defined(__SANITIZE_THREAD__)
        __tsan_release(&m_token);
#endif
    }
    void follow() noexcept {
#if defined(__SANITIZE_THREAD__)
        __tsan_acquire(&m_token);
#endif
    }

private:
    [[maybe_unused]] char m_token = 0;
};

/// The order of a group of tasks: what their starter did before precedes them, and all of them
/// precede what it does after. To be made before the first task and destroyed after the last one.
class TsanTasks {
public:
    TsanTasks() noexcept { m_begin.precede(); }
    ~TsanTasks() { m_end.follow(); }
    TsanTasks(const TsanTasks&) = delete;
    TsanTasks& operator=(const TsanTasks&) = delete;

    /// To be made where a task begins and destroyed where it ends.
    class Task {
    public:
        explicit Task(TsanTasks& tasks) noexcept : m_tasks(tasks) { m_tasks.m_begin.follow(); }
        ~Task() { m_tasks.m_end.precede(); }
        Task(const Task&) = delete;
        Task& operator=(const Task&) = delete;

    private:
        TsanTasks& m_tasks;
    };

private:
    TsanOrder m_begin;
    TsanOrder m_end;
};

/// Tasks of which one ends before the next one begins: each follows those before it.
class TsanSerialTask {
public:
    explicit TsanSerialTask(TsanOrder& order) noexcept : m_order(order) { m_order.follow(); }
    ~TsanSerialTask() { m_order.precede(); }
    TsanSerialTask(const TsanSerialTask&) = delete;
    TsanSerialTask& operator=(const TsanSerialTask&) = delete;

private:
    TsanOrder& m_order;
};

}  // namespace terravox::thread
