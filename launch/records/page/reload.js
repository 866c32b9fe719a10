// A reload comes without the token, which the page took out of its address: this tab still has it.
const token = sessionStorage.getItem("token");
if (token && !location.search) location.replace(`?token=${token}`);
