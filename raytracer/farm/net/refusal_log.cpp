#include "raytracer/farm/net/refusal_log.hpp"

#include <spdlog/spdlog.h>

namespace terravox::net {

RefusalLog::RefusalLog(std::function<void(const std::string&)> say) : m_say(std::move(say)) {
    if (!m_say)
        m_say = [](const std::string& line) { spdlog::warn("{}", line); };
}

void RefusalLog::refused(const std::string& who, const std::string& peer, const std::string& why,
                         Clock::time_point now) {
    auto key = std::pair(who, why);
    if (!m_told.contains(key) && m_told.size() >= kMaxKept) {
        if (now - m_cleared >= std::chrono::seconds(1)) {
            std::erase_if(m_told, [&](const auto& one) { return now - one.second.when >= kQuiet; });
            m_cleared = now;
        }
        if (m_told.size() >= kMaxKept)
            key = {"", why};
    }
    const auto [told, first] = m_told.try_emplace(key);
    if (!first && now - told->second.when < kQuiet) {
        ++told->second.since;
        return;
    }
    std::string line = "farm: refused " + peer + ": " + why;
    if (told->second.since > 0)
        line += " (and " + std::to_string(told->second.since) + " more since, from " +
                (key.first.empty() ? "other addresses" : key.first) + ")";
    told->second = {now, 0};
    m_say(line);
}

}  // namespace terravox::net
