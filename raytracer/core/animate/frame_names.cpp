#include "raytracer/core/animate/frame_names.hpp"

#include <string_view>

#include "common/util/error.hpp"

namespace terravox::animate {

FrameNames::FrameNames(std::string pattern) : m_pattern(std::move(pattern)) {
    const auto refuse = [&] {
        throw util::UsageError(
            "name the frames: -o " + m_pattern +
            "; allowed: one %d or %0Nd (N from 1 to 9) in the file's name, such as "
            "frames/%04d.png");
    };
    const std::size_t at = m_pattern.find('%');
    if (at == std::string::npos || m_pattern.find('%', at + 1) != std::string::npos ||
        m_pattern.find('/', at) != std::string::npos)
        refuse();
    std::size_t end = at + 1;
    if (m_pattern.compare(end, 1, "0") == 0) {
        const char digit = end + 1 < m_pattern.size() ? m_pattern[end + 1] : ' ';
        if (digit < '1' || digit > '9')
            refuse();
        m_digits = static_cast<std::size_t>(digit - '0');
        end += 2;
    }
    if (m_pattern.compare(end, 1, "d") != 0)
        refuse();
    m_before = m_pattern.substr(0, at);
    m_after = m_pattern.substr(end + 1);
}

std::filesystem::path FrameNames::of(int frame) const {
    const std::string digits = std::to_string(frame);
    return m_before + std::string(m_digits > digits.size() ? m_digits - digits.size() : 0, '0') +
           digits + m_after;
}

bool FrameNames::matches(const std::filesystem::path& file) const {
    const std::filesystem::path first = of(0);
    std::error_code ignored;
    const std::filesystem::path folder =
        std::filesystem::weakly_canonical(std::filesystem::absolute(first).parent_path(), ignored);
    if (file.parent_path() != folder)
        return false;
    const std::string name = file.filename().string();
    const std::string before = std::filesystem::path(m_before).filename().string();
    if (name.size() <= before.size() + m_after.size() || !name.starts_with(before) ||
        !name.ends_with(m_after))
        return false;
    const auto number =
        std::string_view(name).substr(before.size(), name.size() - before.size() - m_after.size());
    return number.find_first_not_of("0123456789") == std::string_view::npos;
}

std::filesystem::path FrameNames::ledger() const {
    const std::filesystem::path frames = m_before + "frames" + m_after;
    return frames.parent_path() / ("." + frames.filename().string() + ".done");
}

}  // namespace terravox::animate
