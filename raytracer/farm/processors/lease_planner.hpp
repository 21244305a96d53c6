#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "raytracer/farm/processors/pool_members.hpp"

namespace terravox::processors {

/// Plans which member leases how much, and enters it into the lease book. It has no thread and
/// reads no clock. Not thread-safe.
///
/// Members get bands in proportion to their measured speed, so that all end together (weighted
/// factoring), and enough at once to hide the latency. When nothing is left to
/// lease, idle members repeat what others are computing.
/// Ref: Hummel, Schmidt, Uma, Wein, "Load-sharing in heterogeneous systems via weighted factoring",
/// SPAA 1996.
class LeasePlanner {
public:
    using Time = LeaseBook::Time;

    /// A lease whose band must be submitted to the processor.
    struct Grant {
        MemberId member = 0;
        std::shared_ptr<TileProcessor> processor;
        tiles::RenderTile band;
        bool repeated = false;  ///< another member is computing it, too
    };

    /// @param book, members  outlive the planner
    /// @param min_deadline   minimum deadline of leases of untrusted members; else it is three
    /// times the expected duration
    LeasePlanner(LeaseBook& book, MemberRegistry& members,
                 std::chrono::milliseconds min_deadline) noexcept
        : m_book(book), m_members(members), m_min_deadline(min_deadline) {}

    /// To be called when this many bands of a lost member are back in the book: the next plan()
    /// leases them at once.
    void add_returned(std::size_t bands) noexcept { m_returned += bands; }
    /// Leases bands to all members as far as they can use them.
    /// @param checks_only lease only checks
    [[nodiscard]] std::vector<Grant> plan(Time now, bool checks_only);
    /// @return number of pixels that a member should have leased at once
    [[nodiscard]] std::size_t wanted_pixels(const PoolMember& member) const;

private:
    void reassign_returned(Time now, std::vector<Grant>& out);
    [[nodiscard]] MemberId first_to_be_done() const;
    void plan_checks(MemberId id, PoolMember& member, Time now, std::vector<Grant>& out);
    void plan_member(MemberId id, PoolMember& member, Time now, std::vector<Grant>& out);
    [[nodiscard]] bool repeat_lease(MemberId id, PoolMember& member, Time now,
                                    std::vector<Grant>& out);
    [[nodiscard]] std::optional<double> worthwhile_left_s(const LeaseBook::Open& lease,
                                                          const PoolMember& member, Time now) const;
    [[nodiscard]] Time find_deadline(MemberId id, const PoolMember& member, Time now) const;
    void grant(MemberId id, PoolMember& member, const tiles::RenderTile& band, Time now,
               std::vector<Grant>& out);

    LeaseBook& m_book;
    MemberRegistry& m_members;
    std::chrono::milliseconds m_min_deadline;
    std::size_t m_returned = 0;
};

}  // namespace terravox::processors
