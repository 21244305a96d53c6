#include "voxelserver/make/voxelize/points/step_switches.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/near_words.hpp"

namespace terravox::voxelize {
namespace {

constexpr std::string_view kAll = "all";
constexpr std::string_view kNone = "none";

/// @return nullptr when no step has this key
const StepSwitch* find_switch(std::string_view key) {
    const auto found = std::find_if(kStepSwitches.begin(), kStepSwitches.end(),
                                    [&](const StepSwitch& s) { return key_of(s) == key; });
    return found == kStepSwitches.end() ? nullptr : &*found;
}

void switch_all(bool on, Settings::Steps& steps) {
    for (const StepSwitch& step : kStepSwitches)
        steps.*step.on = on;
}

[[noreturn]] void refuse(std::string_view word) {
    std::vector<std::string> allowed{std::string(kAll), std::string(kNone)};
    for (const StepSwitch& step : kStepSwitches)
        allowed.push_back(key_of(step));
    throw util::UsageError("choose the steps of voxelization: '" + std::string(word) +
                           "' is no step" + util::allowed_words(word, allowed) +
                           ", each step also with - before it to leave it out");
}

/// Applies one word to the switches.
/// @return whether the word is allowed
bool switch_word(std::string_view word, bool first, Settings::Steps& steps) {
    if (word == kAll || word == kNone) {
        switch_all(word == kAll, steps);
        return true;
    }
    const bool on = !word.starts_with('-');
    const StepSwitch* step = find_switch(on ? word : word.substr(1));
    if (step == nullptr)
        return false;
    if (on && first)
        switch_all(false, steps);
    steps.*step->on = on;
    return true;
}

}  // namespace

std::string key_of(const StepSwitch& step) {
    std::string out(step.name);
    std::replace(out.begin(), out.end(), ' ', '_');
    return out;
}

void switch_steps(std::string_view text, Settings::Steps& steps) {
    if (text.empty())
        return;
    std::size_t begin = 0;
    while (begin <= text.size()) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const std::string_view word = text.substr(begin, end - begin);
        if (!switch_word(word, begin == 0, steps))
            refuse(word);
        begin = end + 1;
    }
}

std::string steps_help() {
    constexpr std::size_t kWidth = 24;
    std::string out = "Steps of voxelization (--steps):";
    for (const StepSwitch& step : kStepSwitches) {
        const std::string key = key_of(step);
        out += "\n  " + key + std::string(kWidth - std::min(kWidth - 1, key.size()), ' ') +
               std::string(step.doc);
    }
    return out;
}

}  // namespace terravox::voxelize
