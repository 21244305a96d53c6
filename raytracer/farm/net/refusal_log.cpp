#include "raytracer/farm/net/refusal_log.hpp"
#include "common/util/log.hpp"

namespace terravox::net {

RefusalLog::RefusalLog(std::function<void(const std::string&)> say, std::string what)
    : m_say(std::move(say)), m_what(std::move(what)) {
    if (!m_say)
        m_say = [](const std::string& line) { util::log_warn("{}", line); };
}

void RefusalLog::refused(const std::string& who, const std::string& peer, const std::string& why,
                         Clock::time_point now) {
    auto key = std::pair(who, why);
    if (!m_reported.contains(key) && m_reported.size() >= kMaxKept) {
        if (now - m_cleared >= std::chrono::seconds(1)) {
            std::erase_if(m_reported,
                          [&](const auto& one) { return now - one.second.when >= kQuiet; });
            m_cleared = now;
        }
        if (m_reported.size() >= kMaxKept)
            key = {};
    }
    const auto [reported, first] = m_reported.try_emplace(key);
    if (!first && now - reported->second.when < kQuiet) {
        ++reported->second.since;
        return;
    }
    std::string line = m_what + " " + peer + ": " + why;
    if (reported->second.since > 0)
        line += " (and " + std::to_string(reported->second.since) + " more since, from " +
                (key.first.empty() ? "other addresses" : key.first) + ")";
    reported->second = {now, 0};
    m_say(line);
}

}  // namespace terravox::net
