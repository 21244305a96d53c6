#include "raytracer/farm/processors/pool_members.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terravox::processors {
namespace {

using Seconds = std::chrono::duration<double>;

/// Half-life of the counted pixels and seconds.
constexpr double kHalfLife_s = 4;

}  // namespace

void SpeedMeter::start(Time now) noexcept {
    if (!std::exchange(m_is_busy, true))
        m_counted_until = now;
}

void SpeedMeter::advance(Time now) noexcept {
    if (!m_is_busy)
        return;
    const double passed_s = Seconds(now - m_counted_until).count();
    const double keep = std::exp2(-passed_s / kHalfLife_s);
    m_recent_pixels *= keep;
    m_recent_s = m_recent_s * keep + passed_s;
    m_busy_s += passed_s;
    m_counted_until = now;
}

void SpeedMeter::stop(Time now) noexcept {
    advance(now);
    m_is_busy = false;
}

void SpeedMeter::add_answer(std::size_t pixels) noexcept {
    if (std::exchange(m_is_warming_up, false))
        m_recent_s = 0;
    else
        m_recent_pixels += static_cast<double>(pixels);
}

double SpeedMeter::busy_s(Time now) const noexcept {
    return m_busy_s + (m_is_busy ? Seconds(now - m_counted_until).count() : 0);
}

PoolMember::PoolMember(MemberSpec spec, bool checks_only, Time now)
    : m_spec(std::move(spec)),
      m_checks_only(checks_only),
      m_speed(!m_spec.trusted),
      m_joined(now),
      m_paused(m_spec.paused) {}

bool PoolMember::set_late() noexcept {
    if (std::exchange(m_late, true))
        return false;
    m_on_probation = true;
    return true;
}

void PoolMember::on_idle(Time now) noexcept {
    m_late = false;
    m_speed.stop(now);
}

void PoolMember::on_answer(std::size_t pixels) noexcept {
    m_late = false;
    m_on_probation = false;
    m_speed.add_answer(pixels);
}

void PoolMember::add_band(std::size_t pixels) noexcept {
    ++m_bands;
    m_pixels += pixels;
}

const char* PoolMember::state() const noexcept {
    if (m_late)
        return "late";
    if (m_draining)
        return "draining";
    if (m_paused)
        return "paused";
    return m_speed.is_busy() ? "working" : "waiting";
}

MemberStatus PoolMember::status(MemberId id, std::size_t leases, Time now) const {
    const double here_s = std::max(std::chrono::duration<double>(now - m_joined).count(), 1e-6);
    MemberStatus out;
    out.id = id;
    out.name = m_spec.name;
    out.kind = m_spec.kind;
    out.state = state();
    out.threads = m_spec.threads;
    out.bands = m_bands;
    out.pixels = m_pixels;
    out.pixels_per_s = pixels_per_s();
    out.latency_s = latency_s();
    out.busy_share = std::min(m_speed.busy_s(now) / here_s, 1.0);
    out.leases = leases;
    return out;
}

MemberId MemberRegistry::add(MemberSpec spec, bool checks_only, Time now) {
    const MemberId id = m_next_id++;
    m_members.try_emplace(id, std::move(spec), checks_only, now);
    return id;
}

std::optional<PoolMember> MemberRegistry::remove(MemberId id) {
    const auto found = m_members.find(id);
    if (found == m_members.end())
        return std::nullopt;
    std::optional<PoolMember> out(std::move(found->second));
    m_members.erase(found);
    return out;
}

PoolMember* MemberRegistry::find(MemberId id) noexcept {
    const auto found = m_members.find(id);
    return found == m_members.end() ? nullptr : &found->second;
}

const PoolMember* MemberRegistry::find(MemberId id) const noexcept {
    const auto found = m_members.find(id);
    return found == m_members.end() ? nullptr : &found->second;
}

bool MemberRegistry::has_workers() const noexcept {
    return std::any_of(m_members.begin(), m_members.end(),
                       [](const auto& m) { return !m.second.checks_only(); });
}

bool MemberRegistry::traces_here() const noexcept {
    return m_stands_in || std::any_of(m_members.begin(), m_members.end(), [this](const auto& m) {
               return m.second.spec().trusted && takes_work(m.second);
           });
}

double MemberRegistry::pixels_per_s() const noexcept {
    double sum = 0;
    for (const auto& [id, member] : m_members)
        if (takes_work(member))
            sum += member.pixels_per_s();
    return sum;
}

bool MemberRegistry::claim_checker() noexcept {
    const bool has_trusted = std::any_of(m_members.begin(), m_members.end(),
                                         [](const auto& m) { return m.second.spec().trusted; });
    return !has_trusted && !std::exchange(m_checker_claimed, true);
}

namespace {

constexpr std::chrono::seconds kWarnAfter{1};
constexpr std::chrono::seconds kWarnEvery{10};

}  // namespace

void AbsenceWatchdog::set_present(Time now) noexcept {
    m_absent_before = absent_for(now);
    m_absent_since.reset();
}

void AbsenceWatchdog::set_absent(Time now) noexcept {
    if (!m_absent_since)
        m_absent_since = now;
}

void AbsenceWatchdog::set_answered() noexcept {
    m_absent_before = {};
    m_warned.reset();
}

AbsenceWatchdog::Alarm AbsenceWatchdog::poll(Time now) noexcept {
    if (!m_absent_since)
        return Alarm::kNone;
    if (m_timeout && absent_for(now) > *m_timeout)
        return Alarm::kTimeout;
    if (absent_for(now) <= kWarnAfter || (m_warned && now - *m_warned <= kWarnEvery))
        return Alarm::kNone;
    m_warned = now;
    return Alarm::kWarn;
}

}  // namespace terravox::processors
