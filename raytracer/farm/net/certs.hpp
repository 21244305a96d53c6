#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace terravox::net {

inline constexpr int kMaxCertificate_days = 3650;

/// Makes certificates for a farm: a CA of its own if the folder has none (ca.pem, ca.key; valid for
/// ten years), and for each name NAME.pem and NAME.key. All carry the DNS name "terravox-farm" in
/// addition to their own, and a role (peer_certificate.hpp), which each end checks; the role does
/// not depend on which side listens and which dials. ca.key is used to make more certificates and
/// is needed on no machine of the farm. Keys (P-256) are readable by their owner alone. Existing
/// files are not changed.
/// @param names of small letters, digits, '-' and '.', 1 to 63 characters, not "ca"; none:
/// coordinator, worker
/// @param role of all of them: kWorkerRole or kCoordinatorRole; empty: the name "coordinator" is a
/// coordinator's, all others are workers'
/// @param days 1 to kMaxCertificate_days
/// @throws UsageError for an invalid name or number; Error when a file of such a name exists or
/// cannot be written: then this call has made none
void make_certs(const std::filesystem::path& folder, const std::vector<std::string>& names,
                int days, const std::string& role = {});

/// Adds the certificates NAME.pem of the folder to the CA's list of revoked ones, ca.crl next to
/// ca.pem, which is created if there is none. The list must be copied next to ca.pem on each
/// machine: from then on new connections are refused, and existing ones end within seconds.
/// @throws UsageError for an invalid name; Error for files that cannot be read or written, or that
/// the CA has not signed
void revoke_certs(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace terravox::net
