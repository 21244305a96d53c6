#pragma once

#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <type_traits>
#include <utility>

namespace terravox::thread {

/// Makes an uninterruptible call, such as a DNS lookup, on a thread of its own, and stops waiting
/// for it on request.
/// @param call must own all that it accesses: it keeps running, detached, when the stop request
/// comes first
/// @return nullopt when stopped before the call has returned
/// @throws whatever the call throws
template <class Call>
[[nodiscard]] std::optional<std::invoke_result_t<Call&>> call_until_stopped(
    Call call, const std::stop_token& stop) {
    struct Outcome {
        std::mutex mutex;
        std::condition_variable_any came;
        std::optional<std::invoke_result_t<Call&>> value;
        std::exception_ptr failure;
    };
    const auto outcome = std::make_shared<Outcome>();
    std::thread([outcome, call = std::move(call)]() mutable {
        std::optional<std::invoke_result_t<Call&>> value;
        std::exception_ptr failure;
        try {
            value = call();
        } catch (...) {
            failure = std::current_exception();
        }
        const std::lock_guard lock(outcome->mutex);
        outcome->value = std::move(value);
        outcome->failure = failure;
        outcome->came.notify_all();
    }).detach();
    std::unique_lock lock(outcome->mutex);
    const auto ended = [&] { return outcome->value || outcome->failure; };
    if (!outcome->came.wait(lock, stop, ended))
        return std::nullopt;
    if (outcome->failure)
        std::rethrow_exception(outcome->failure);
    return std::move(outcome->value);
}

}  // namespace terravox::thread
